#include <vcd/runtime/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <string>

#include "scene_state.h"

namespace vcd {
namespace {

using Vec = std::array<double, 3>;

struct Placed {
  ToGrid to_grid;
  float low[3], high[3];  // its box in the world
};

float down(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float up(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

// Nothing if the transform cannot be used.
std::optional<Placed> place(const SceneInstance& instance, const Transform& to_world) {
  double m[3][3], t[3];
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) m[i][j] = to_world.rows[i][j];
    t[i] = to_world.rows[i][3];
  }
  const auto cofactor = [&](size_t i, size_t j) {
    const size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const double determinant = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
  double size = 1;  // Hadamard: of a matrix with such rows the determinant is at most this
  for (const auto& row : m) size *= std::sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
  constexpr double kFlattest = 1e-6;
  if (!(std::abs(determinant) > kFlattest * size) || !std::isfinite(size + t[0] + t[1] + t[2])) return std::nullopt;

  Placed placed{};
  Vec middle;
  for (size_t a = 0; a < 3; ++a) {
    const double low = instance.box_min[a], high = instance.box_max[a];
    if (!(low < high) || !usable_extent(instance.box_max[a] - instance.box_min[a])) return std::nullopt;
    middle[a] = 0.5 * (low + high);
  }
  for (size_t i = 0; i < 3; ++i) {
    double centre = t[i], reach = 0;
    for (size_t j = 0; j < 3; ++j) {
      centre += m[i][j] * middle[j];
      reach += std::abs(m[i][j]) * 0.5 * (double{instance.box_max[j]} - double{instance.box_min[j]});
    }
    placed.to_grid.centre[i] = static_cast<float>(centre);
    placed.low[i] = down(centre - reach), placed.high[i] = up(centre + reach);
  }
  const GridFrame frame = make_grid_frame(instance.box_min, instance.box_max);
  for (size_t i = 0; i < 3; ++i) {
    // The centre's own rounding goes into the offset: the object's point that stands exactly there.
    double offset = -double{frame.min[i]};
    for (size_t j = 0; j < 3; ++j) {
      const double inverse = cofactor(j, i) / determinant;
      placed.to_grid.column[j][i] = static_cast<float>(inverse * double{frame.scale[i]});
      offset += inverse * (double{placed.to_grid.centre[j]} - t[j]);
    }
    placed.to_grid.offset[i] = static_cast<float>(offset * double{frame.scale[i]});
  }
  bool finite = true;
  for (size_t j = 0; j < 3; ++j) {
    auto& column = placed.to_grid.column[j];
    for (size_t i = 0; i < 3; ++i) column[3] += std::abs(column[i]);
    finite &=
        std::isfinite(column[3] + placed.to_grid.centre[j] + placed.to_grid.offset[j] + placed.low[j] + placed.high[j]);
  }
  return finite ? std::optional(placed) : std::nullopt;
}

// Room between the mesh and the box, as bakers leave it: what a line does that touches the box is then no matter of
// rounding.
void pad_box(SceneInstance& instance) {
  float longest = 0;
  for (int a = 0; a < 3; ++a) longest = std::max(longest, instance.box_max[a] - instance.box_min[a]);
  for (int a = 0; a < 3; ++a) {
    const float pad = std::max(instance.box_max[a] - instance.box_min[a], longest * 0x1p-6f) * 0x1p-10f;
    const float size = std::max(std::abs(instance.box_min[a]), std::abs(instance.box_max[a])) * 0x1p-22f;
    instance.box_min[a] -= pad + size, instance.box_max[a] += pad + size;
  }
}

// Eight boxes a node: each node is split in halves along the longest axis of its centres, three times.
class Builder {
 public:
  Builder(std::span<const Placed> placed, std::vector<SceneNode>& nodes) : placed_(placed), nodes_(nodes) {}

  void build() {
    std::vector<uint32_t> order(placed_.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.clear();
    if (!order.empty()) add(order);
  }

 private:
  uint32_t add(std::span<uint32_t> order) {
    const auto at = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    std::array<std::span<uint32_t>, 8> parts;
    parts[0] = order;
    size_t count = 1;
    for (int round = 0; round < 3; ++round)
      for (size_t k = count; k-- > 0;)
        if (parts[k].size() > 1) {
          const size_t half = split(parts[k]);
          parts[count++] = parts[k].subspan(half);
          parts[k] = parts[k].first(half);
        }
    for (size_t k = 0; k < 8; ++k) {
      float low[3], high[3];
      std::fill_n(low, 3, std::numeric_limits<float>::infinity());
      std::fill_n(high, 3, -std::numeric_limits<float>::infinity());
      for (uint32_t i : k < count ? parts[k] : std::span<uint32_t>{})
        for (int a = 0; a < 3; ++a)
          low[a] = std::min(low[a], placed_[i].low[a]), high[a] = std::max(high[a], placed_[i].high[a]);
      const uint32_t child = k >= count ? kLeaf : parts[k].size() == 1 ? kLeaf | parts[k][0] : add(parts[k]);
      SceneNode& node = nodes_[at];
      for (int a = 0; a < 3; ++a) node.low[a][k] = low[a], node.high[a][k] = high[a];
      node.child[k] = child;
    }
    return at;
  }

  size_t split(std::span<uint32_t> order) {
    const auto centre = [&](uint32_t i, int a) { return placed_[i].to_grid.centre[a]; };
    int axis = 0;
    float widest = -1;
    for (int a = 0; a < 3; ++a) {
      float low = centre(order[0], a), high = low;
      for (uint32_t i : order) low = std::min(low, centre(i, a)), high = std::max(high, centre(i, a));
      if (high - low > widest) widest = high - low, axis = a;
    }
    const size_t half = order.size() / 2;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](uint32_t x, uint32_t y) {
                       return centre(x, axis) != centre(y, axis) ? centre(x, axis) < centre(y, axis) : x < y;
                     });
    return half;
  }

  std::span<const Placed> placed_;
  std::vector<SceneNode>& nodes_;
};

}  // namespace

std::optional<Error> Scene::State::set(std::span<const Transform> to_world) {
  std::vector<Placed> placed;
  for (size_t i = 0; i < instances.size(); ++i) {
    const auto one = place(instances[i], to_world[i]);
    if (!one)
      return Error{ErrorCode::usage, "instance " + std::to_string(i) +
                                         ": its box is empty, or its transform is not finite or cannot be inverted"};
    placed.push_back(*one);
  }
  std::vector<SceneNode> nodes;
  Builder(placed, nodes).build();
  data.nodes = std::move(nodes);
  data.to_grid.clear();
  for (size_t i = 0; i < placed.size(); ++i) {
    data.to_grid.push_back(placed[i].to_grid);
    instances[i].to_world = to_world[i];
  }
  return std::nullopt;
}

SceneInstance SceneInstance::of(Object object, const Transform& to_world) {
  SceneInstance instance{object, {}, {}, to_world};
  std::copy_n(object.record().box_min, 3, instance.box_min);
  std::copy_n(object.record().box_max, 3, instance.box_max);
  return instance;
}

Scene::Scene(std::unique_ptr<State> state) : state_(std::move(state)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;
size_t Scene::size() const noexcept { return state_->instances.size(); }
uint32_t Scene::mask(uint32_t instance) const noexcept { return state_->data.masks[instance]; }

Result<Scene> Scene::build(std::span<const SceneInstance> instances, const std::string& kernel) try {
  auto state = std::make_unique<State>();
  const std::vector<Kernels> usable = usable_kernels();
  const auto chosen =
      std::find_if(usable.begin(), usable.end(), [&](const Kernels& k) { return kernel.empty() || kernel == k.name; });
  if (chosen == usable.end())
    return Error{ErrorCode::usage, "kernel \"" + kernel + "\": this processor has none of that name"};
  state->kernels = chosen->scene;
  state->instances.assign(instances.begin(), instances.end());
  std::vector<Transform> transforms;
  std::map<const ObjectData*, const ObjectData*> in_grid;
  for (SceneInstance& instance : state->instances) {
    if (!instance.object) pad_box(instance);
    const ObjectData* object = instance.object && instance.object->answers() ? instance.object->data_ : nullptr;
    if (object && !in_grid[object]) {
      ObjectData copy = *object;
      copy.frame = {{0, 0, 0, 0}, {1, 1, 1, 0}};
      copy.many = (fits_gathers(copy.tree) ? *chosen : usable.back()).at_depth[copy.record->depth - 1u];
      in_grid[object] = &state->in_grid.emplace_back(copy);
    }
    state->data.objects.push_back(object ? in_grid[object] : nullptr);
    state->data.masks.push_back(instance.mask);
    transforms.push_back(instance.to_world);
    ToFrame& frame = state->data.to_frame.emplace_back();
    for (int a = 0; a < 3; ++a) {
      frame.unit[a] = (instance.box_max[a] - instance.box_min[a]) / kGrid;
      frame.min[a] = instance.box_min[a];
    }
  }
  if (auto error = state->set(transforms)) return *error;
  return Scene(std::move(state));
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "scene: out of memory"};
}

std::optional<Error> Scene::set_transforms(std::span<const Transform> to_world) try {
  if (to_world.size() != size())
    return Error{ErrorCode::usage, "scene: " + std::to_string(to_world.size()) + " transforms for " +
                                       std::to_string(size()) + " instances"};
  return state_->set(to_world);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "scene: out of memory"};
}

Visibility Scene::classify(const Segment& segment, const SceneQuery& query) const noexcept {
  Visibility answer;
  classify(std::span(&segment, 1), std::span(&answer, 1), query);
  return answer;
}

void Scene::classify(std::span<const Segment> segments, std::span<Visibility> answers,
                     const SceneQuery& query) const noexcept {
  std::fill_n(answers.begin(), segments.size(), Visibility::clear);
  state_->kernels.segments(state_->data, segments, query, {answers.data(), nullptr});
}

Segment Scene::in_object(uint32_t instance, const Segment& segment) const noexcept {
  Segment s = in_grid(state_->data.to_grid[instance], segment);
  const ToFrame& frame = state_->data.to_frame[instance];
  for (int a = 0; a < 3; ++a) {
    s.origin[a] = s.origin[a] * frame.unit[a] + frame.min[a];
    s.direction[a] *= frame.unit[a];
  }
  return s;
}

Scene::Open Scene::classify(std::span<const Segment> segments, std::span<Visibility> answers, std::span<OpenPair> open,
                            const SceneQuery& query) const noexcept {
  std::fill_n(answers.begin(), segments.size(), Visibility::clear);
  OpenSink sink{open};
  state_->kernels.segments(state_->data, segments, query, {answers.data(), &sink});
  // Some of them were blocked by a later instance.
  const auto kept = open.first(sink.count);
  const auto end = std::remove_if(kept.begin(), kept.end(),
                                  [&](const OpenPair& p) { return answers[p.segment] == Visibility::blocked; });
  std::sort(kept.begin(), end, [](const OpenPair& a, const OpenPair& b) {
    return a.segment != b.segment ? a.segment < b.segment
           : a.length != b.length ? a.length > b.length
                                  : a.instance < b.instance;
  });
  return {static_cast<size_t>(end - kept.begin()), sink.complete};
}

}  // namespace vcd

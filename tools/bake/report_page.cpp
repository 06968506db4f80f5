// The page of a run: what was baked, what failed and why, what was left out.
#include "bake/report.h"

#include <cstdio>
#include <map>

#include "common/paths.h"
#include "common/progress.h"
#include "common/uri.h"

namespace vcd::tools {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --ink: #1b1f24; --dim: #5c6670; --line: #d8dde3; --bad: #b3261e; --paper: #fff }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ec; --dim: #9aa4ae; --line: #3a424b; --bad: #ff8a80; --paper: #14171a } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto; max-width: 75rem; padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2.2rem }
.numbers { display: flex; flex-wrap: wrap; gap: .5rem 2.5rem; padding: 0; list-style: none }
.numbers b { display: block; font-size: 1.6rem; font-weight: 600 } .numbers span { color: var(--dim) }
.bad b, td.bad { color: var(--bad) }
.wide { overflow-x: auto } table { border-collapse: collapse; width: 100% }
th { text-align: left; color: var(--dim); font-weight: 500; border-bottom: 1px solid var(--line) }
td, th { padding: .25rem .8rem .25rem 0; vertical-align: top } tr { content-visibility: auto }
td { border-bottom: 1px solid var(--line); overflow-wrap: anywhere }
td.n, th.n, td.bad { white-space: nowrap } td.n, th.n { text-align: right }
summary { cursor: pointer; font-weight: 600 }
@media print { tr { content-visibility: visible } }
)";

std::string escaped(const std::string& text) {
  static const std::map<char, const char*> kNames = {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string out;
  for (const char c : text) {
    const auto name = kNames.find(c);
    if (name != kNames.end()) out += name->second;
    else out += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return out;
}

// What a member holds, whatever it holds.
std::string text_of(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) return "";
  const Json& value = object[key];
  if (value.is_string()) return value.get<std::string>();
  if (value.is_object() && value.contains("bytes") && value["bytes"].is_string())
    return "bytes " + value["bytes"].get<std::string>();
  return value.is_null() ? "" : value.dump();
}
double number_of(const Json& object, const char* key) {
  return object.is_object() && object.contains(key) && object[key].is_number() ? object[key].get<double>() : 0;
}
const Json& list_of(const Json& object, const char* key) {
  static const Json kEmpty = Json::array();
  return object.is_object() && object.contains(key) && object[key].is_array() ? object[key] : kEmpty;
}
Json member(const Json& object, const char* key) {
  return object.is_object() && object.contains(key) ? object[key] : Json(nullptr);
}

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

std::string cell(const std::string& text, const char* kind = "") {
  return std::string("<td") + (*kind ? std::string(" class=\"") + kind + "\"" : "") + ">" + escaped(text) + "</td>";
}

// The asset's name, which links to the page of its sidecar if the report knows one.
std::string asset_cell(const Json& file, const std::filesystem::path& folder) {
  const auto page = path_from_json(member(file, "page"));
  if (!page) return cell(text_of(file, "input"));
  const auto here = std::filesystem::absolute(folder / "report").parent_path();
  return "<td><a href=\"" + uri_of(std::filesystem::absolute(*page).lexically_relative(here)) + "\">" +
         escaped(text_of(file, "input")) + "</a></td>";
}

// A section of the page: so many assets, and the rows that tell of them.
struct Part {
  std::string rows;
  size_t count = 0;

  void add(const std::string& more) { rows += more, ++count; }
  void add_row(const std::string& cells) { add("<tr>" + cells + "</tr>\n"); }
  std::string shown(const std::string& title, const char* head, bool open = true) const {
    if (count == 0) return "";
    const std::string body = "<div class=\"wide\"><table><thead><tr>" + std::string(head) + "</tr></thead><tbody>" +
                             rows + "</tbody></table></div>\n";
    return "<section><h2>" + title + " (" + std::to_string(count) + ")</h2>" +
           (open ? body : "<details><summary>Show</summary>" + body + "</details>") + "</section>\n";
  }
};

// A row an object: an asset's first row names it.
std::string baked_rows(const Json& file, const std::filesystem::path& folder) {
  std::string rows;
  for (const Json& object : list_of(file, "objects")) {
    const Json plan = member(object, "plan"), audit = member(object, "audit"), shares = member(object, "shares");
    std::string gain = "";
    for (const Json& f : list_of(plan, "forecasts"))
      if (number_of(f, "depth") == number_of(plan, "depth")) gain = format("%.2f", number_of(f, "gain"));
    const bool is_none = text_of(object, "method") == "none";
    const std::string method =
        is_none ? "not worth it" : text_of(object, "method") + ", depth " + text_of(object, "depth");
    rows += "<tr>" + (rows.empty() ? asset_cell(file, folder) : cell("")) + cell(text_of(object, "name")) +
            cell(readable_count(number_of(object, "triangle_count")), "n") + cell(method) +
            cell(is_none ? "" : format("%.1f %%", 100 * (1 - number_of(shares, "unclassified"))), "n") +
            cell(gain, "n") +
            cell(audit.is_object() ? format("%.2g", number_of(audit, "wrong_rate_bound_95")) : "", "n") +
            cell(rows.empty() ? readable_bytes(static_cast<uint64_t>(number_of(file, "bytes"))) : "", "n") +
            cell(object.value("reused", false)      ? "reused"
                 : number_of(object, "seconds") > 0 ? readable_seconds(number_of(object, "seconds"))
                                                    : "",
                 "n") +
            "</tr>\n";
  }
  return rows;
}

constexpr const char* kBakedHead =
    "<th>Asset<th>Object<th class=n>Triangles<th>Method<th class=n>Lines resolved<th class=n>Gain forecast<th "
    "class=n>Wrong, 95 % bound<th class=n>Bytes<th class=n>Bake";

// Without the name of the asset, which stands beside it.
std::string why_failed(const Json& file, const std::string& input) {
  std::string why = text_of(file, "error");
  if (why.starts_with(input + ": ")) why.erase(0, input.size() + 2);
  const std::string older = text_of(file, "old_sidecar");
  return older.empty() ? why : why + " (an older sidecar is in place, " + older + ")";
}

std::string number_item(const std::string& number, const char* what, bool bad = false) {
  return std::string("<li") + (bad ? " class=\"bad\"" : "") + "><b>" + escaped(number) + "</b><span>" + what +
         "</span></li>";
}

}  // namespace

std::string report_page(const Json& report, const std::filesystem::path& folder) {
  Part baked, known, failed, left_out, pruned;
  for (const Json& error : list_of(report, "errors"))
    failed.add_row(cell("input", "bad") + cell("") + cell(text_of(error, "error")));
  for (const Json& file : list_of(report, "files")) {
    const std::string fate = text_of(file, "fate"), input = text_of(file, "input");
    if (fate == "baked") baked.add(baked_rows(file, folder));
    else if (fate == "up-to-date") known.add(baked_rows(file, folder));
    else failed.add_row(cell(text_of(file, "kind"), "bad") + cell(input) + cell(why_failed(file, input)));
    for (const Json& note : list_of(file, "notes"))
      if (note.is_string()) left_out.add_row(cell(input) + cell(note.get<std::string>()));
  }
  for (const Json& path : list_of(report, "pruned"))
    pruned.add_row(cell(path.is_string() ? path.get<std::string>() : text_of({{"p", path}}, "p")));
  const Json totals = member(report, "totals");
  const auto count = [&](const char* key) { return text_of(totals, key); };
  return std::string(
             "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
             "content=\"width=device-width\">") +
         "<title>vc-bake report</title><style>" + kStyle +
         "</style>\n<h1>Sidecars of a library</h1><ul class=\"numbers\">" + number_item(count("assets"), "assets") +
         number_item(count("baked"), "baked") + number_item(count("up_to_date"), "up to date") +
         number_item(std::to_string(failed.count), "failed or not run", failed.count > 0) +
         number_item(readable_bytes(static_cast<uint64_t>(number_of(totals, "bytes"))), "of sidecars") +
         number_item(readable_seconds(number_of(report, "seconds")), "wall time") + "</ul>\n" +
         failed.shown("Failed", "<th>What<th>Asset<th>Why") + baked.shown("Baked", kBakedHead) +
         left_out.shown("Left out of assets", "<th>Asset<th>What and why") +
         pruned.shown("Sidecars removed, their assets are gone", "<th>Sidecar") +
         known.shown("Up to date", kBakedHead, false) + "<p>vcd " + escaped(text_of(report, "version")) +
         ". <i>Wrong</i>: share of random lines whose answer an audit against exact arithmetic found wrong, upper end "
         "of the 95 % interval. " +
         "<i>Gain forecast</i>: of single shadow rays that pierce the box.</p></html>\n";
}

}  // namespace vcd::tools

#include "render/image.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include "render/false_colour.h"
#include "support/files.h"

namespace vcd::test {

using namespace render;

namespace {

Image gradient() {
  Image image(17, 5);
  for (size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = {static_cast<float>(i) / 84, 1 - static_cast<float>(i) / 84, i == 3 ? 7.5f : 0.25f};
  return image;
}

std::vector<uint8_t> read_png(const std::filesystem::path& path, uint32_t& width, uint32_t& height) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
  png.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> bytes(PNG_IMAGE_SIZE(png));
  EXPECT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
  width = png.width, height = png.height;
  return bytes;
}

TEST(Picture, PngHoldsSrgb) {
  const TemporaryFolder folder;
  ASSERT_FALSE(write_png(folder / "a.png", gradient()));
  uint32_t width = 0, height = 0;
  const auto bytes = read_png(folder / "a.png", width, height);
  EXPECT_EQ(width, 17u);
  EXPECT_EQ(height, 5u);
  EXPECT_EQ(bytes[0], 0);            // black red
  EXPECT_EQ(bytes[1], 255);          // full green
  EXPECT_EQ(bytes[2], 137);          // a quarter of the light is 137 of 255 in sRGB (IEC 61966-2-1)
  EXPECT_EQ(bytes[3 * 3 + 2], 255);  // clamped
}

TEST(Picture, ExrHoldsTheExactFloats) {
  const TemporaryFolder folder;
  const Image image = gradient();
  ASSERT_FALSE(write_exr(folder / "a.exr", image));
  Imf::InputFile file((folder / "a.exr").c_str());
  Imf::Array2D<float> blue(5, 17);
  Imf::FrameBuffer frame;
  frame.insert("B", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&blue[0][0]), sizeof(float), 17 * sizeof(float)));
  file.setFrameBuffer(frame);
  file.readPixels(0, 4);
  for (size_t i = 0; i < image.pixels.size(); ++i) EXPECT_EQ(blue[static_cast<int>(i / 17)][i % 17], image.pixels[i].z);
}

TEST(Picture, AFolderThatIsNotThereIsAnErrorThatNamesTheFile) {
  const TemporaryFolder folder;
  for (const auto& error :
       {write_png(folder / "none/a.png", gradient()), write_exr(folder / "none/a.exr", gradient())}) {
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->code, ErrorCode::io);
    EXPECT_NE(error->message.find("none/a."), std::string::npos);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Picture, DifferenceIsMeasuredOverAllChannels) {
  Image a(2, 1), b(2, 1);
  b.pixels[1] = {0.3f, 0, 0};
  const Difference difference = compare(a, b);
  EXPECT_EQ(difference.pixels, 1u);
  EXPECT_NEAR(difference.maximum, 0.3, 1e-7);
  EXPECT_NEAR(difference.rmse, std::sqrt(0.09 / 6), 1e-7);
  EXPECT_NEAR(amplified_difference(a, b, 2).pixels[1].x, 0.6, 1e-6);
}

TEST(FalseColour, BrightnessGrowsWithTheCountAndTheScaleStandsBelow) {
  std::vector<double> counts(200 * 10);
  for (size_t i = 0; i < counts.size(); ++i) counts[i] = static_cast<double>(i % 200);
  const Image image = false_colour(counts, 200, 10, 100, "tests");
  EXPECT_EQ(image.width, 200u);
  EXPECT_GT(image.height, 10u);
  const auto light = [&](size_t x) {
    const Vec3 c = image.pixels[x];
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
  };
  for (size_t x = 0; x < 99; ++x) EXPECT_LE(light(x), light(x + 1) + 1e-3f);
  EXPECT_EQ(light(120), light(199));  // beyond the scale
  uint64_t white = 0;
  for (size_t i = 2000; i < image.pixels.size(); ++i) white += image.pixels[i].x == 1 && image.pixels[i].z == 1;
  EXPECT_GT(white, 50u);  // figures and caption
}

TEST(FalseColour, AFewBrightPixelsDoNotSpoilTheScale) {
  std::vector<double> counts(1000, 90);
  counts[0] = 1e6;
  EXPECT_EQ(scale_for(counts), 100);
  EXPECT_EQ(scale_for(std::vector<double>(10, 0)), 1);
}

}  // namespace
}  // namespace vcd::test

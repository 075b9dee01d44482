// Arrays, tracks, masks and embeddings from files.
#include <doctest/doctest.h>

#include <cmath>

#include "base/file.h"
#include "metrics/clip.h"
#include "metrics/video_tracks.h"
#include "records/array_file.h"
#include "scene/image_file.h"
#include "splat/video.h"
#include "unit/input_error.h"
#include "unit/metrics/npz_bytes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::metrics;
using namespace physmas::testing;

namespace {

// Two frames of three points; point 2 has no position in frame 1.
std::string tracks_npz(bool deflate) {
  const float nan = std::nanf("");
  return zip({{"tracks.npy", npy<float>("<f4", "(1, 2, 3, 2)", {0, 0, 1, 0, 2, 0, 5, 1, 6, 1, nan, nan})},
              {"visibility.npy", npy<uint8_t>("|b1", "(1, 2, 3)", {1, 1, 1, 1, 0, 1})}},
             deflate);
}

Image square_frame(int left, int top) {
  Image image(96, 96, 3);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      const int u = x - left, v = y - top;
      // A smooth texture that moves with the square: flow needs gradients in both directions.
      const bool in = u >= 0 && v >= 0 && u < 60 && v < 60;
      const double c = 128 + 60 * std::sin(0.35 * u + 0.1 * v) + 60 * std::cos(0.4 * v - 0.15 * u);
      for (int k = 0; k < 3; ++k) image.at(x, y)[k] = in ? static_cast<uint8_t>(std::min(255.0, std::max(0.0, c))) : 20;
    }
  }
  return image;
}

}  // namespace

TEST_CASE("eval: tracks come from stored and deflated .npz and from JSON alike") {
  const TemporaryFolder folder;
  write_file(folder / "stored.npz", tracks_npz(false));
  write_file(folder / "deflated.npz", tracks_npz(true));
  write_file(folder / "t.json",
             R"({"tracks": [[[[0,0],[1,0],[2,0]],[[5,1],[6,1],[null,null]]]], "visibility": [[[1,1,true],[1,0,1]]]})");
  for (const char* name : {"stored.npz", "deflated.npz", "t.json"}) {
    const Tracks tracks = load_tracks(folder / name, 64, 32);
    REQUIRE(tracks.frames() == 2);
    REQUIRE(tracks.points() == 3);
    CHECK(tracks.position[1][0] == Eigen::Vector2d(5.5, 1.5));  // the first pixel's centre is at 0.5 here
    CHECK(tracks.visible[0] == std::vector<uint8_t>{1, 1, 1});
    CHECK(tracks.visible[1] == std::vector<uint8_t>{1, 0, 0});
  }
}

TEST_CASE("eval: an archive that is cut anywhere, or damaged, is refused") {
  const auto error = [](const std::string& bytes) {
    return message_of([&] { parse_arrays(bytes, "a.npz", {"tracks"}); });
  };
  for (const bool deflate : {false, true}) {
    const std::string whole = tracks_npz(deflate);
    CHECK(error(whole) == "no error");
    for (size_t size = 0; size < whole.size(); ++size) {
      CAPTURE(size);
      CHECK(error(whole.substr(0, size)) != "no error");
    }
    // A byte of the data that is another one is damage, but for the mark at the end of what is deflated: nothing comes
    // after it. Other bytes may be times and versions.
    const size_t data = whole.find("tracks.npy") + 10, last = whole.find("PK\x03\x04", data) - (deflate ? 1 : 0);
    for (size_t i = 0; i < whole.size(); ++i) {
      CAPTURE(i);
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 0xff);
      const std::string message = error(damaged);
      if (i >= data && i < last) CHECK(message.find("a.npz: tracks.npy: found damaged data") != std::string::npos);
    }
  }
}

TEST_CASE(
    "eval: entries of an archive that are too large, encrypted, compressed otherwise or twice there are refused") {
  const std::string entry(1000, 'x');
  // Fields of the first entry, in its own header and in the directory.
  const auto error = [&](std::string bytes, const std::string& name, int at, const std::string& value) {
    if (at > 0) bytes.replace(bytes.find("PK\x03\x04") + at - 2, value.size(), value);
    if (at > 0) bytes.replace(bytes.find("PK\x01\x02") + at, value.size(), value);
    return message_of([&] { parse_arrays(bytes, "a.npz", {name}); });
  };
  constexpr int kFlags = 8, kMethod = 10, kSize = 24;
  const std::string stored = zip({{"a.npy", entry}}, false), deflated = zip({{"a.npy", entry}}, true);
  CHECK(error(stored, "a", kFlags, le(1, 2)).find("an encrypted entry") != std::string::npos);
  CHECK(error(stored, "a", kMethod, le(12, 2)).find("compression method 12") != std::string::npos);
  for (const std::string& bytes : {stored, deflated}) {
    CHECK(error(bytes, "a", kSize, le(1ul << 28, 4)).find("sizes that fit") != std::string::npos);
    CHECK(error(bytes, "a", kSize, le(1ul << 30, 4)).find("at most 536870912 bytes") != std::string::npos);
  }
  CHECK(error(deflated, "a", kSize, le(999, 4)).find("damaged data") != std::string::npos);
  CHECK(error(deflated, "a", kSize, le(1001, 4)).find("damaged data") != std::string::npos);
  CHECK(error(stored, "b", 0, "").find("a.npz: b.npy: found no such entry, expected it among a.npy") !=
        std::string::npos);
  CHECK(error(zip({{"a.npy", entry}, {"a.npy", entry}}, false), "a", 0, "").find("twice") != std::string::npos);
}

TEST_CASE("eval: arrays that are not what they say are refused") {
  const auto refused = [](const std::string& bytes) {
    return message_of([&] { parse_npy(bytes, "a.npz", "tracks"); });
  };
  CHECK(refused(npy<float>("<f4", "(3,)", {1, 2})).find("8 bytes of data") != std::string::npos);
  CHECK(refused(npy<float>(">f4", "(2,)", {1, 2})).find("type >f4") != std::string::npos);
  CHECK(refused(npy<float>("|O", "(2,)", {1, 2})).find("type |O") != std::string::npos);
  CHECK(refused(npy<float>("<f4", "(67108864, 67108864)", {1})).find("2^26") != std::string::npos);
  CHECK(refused(npy<float>("<f4", "(1152921504606846976, 0, 2)", {})).find("2^26") != std::string::npos);
  CHECK(refused(npy<float>("<f4", "(-1,)", {1})).find("header") != std::string::npos);
  CHECK(refused("").find("no numpy header") != std::string::npos);
  CHECK(parse_npy(npy<float>("<f4", "()", {7}), "a", "b").values == std::vector<double>{7});
  const TemporaryFolder folder;
  for (const char* text : {R"({"tracks": [[1,2],[3]], "visibility": []})", R"({"tracks": [[1,2],3], "visibility": []})",
                           R"({"tracks": ["x"], "visibility": []})", R"({"visibility": []})", R"([])"}) {
    write_file(folder / "t.json", text);
    CHECK(message_of([&] { load_tracks(folder / "t.json", 10, 10); }).find("/tracks") != std::string::npos);
  }
  const std::map<std::string, Array> long_and_empty = {{"tracks", {{size_t{1} << 25, 0, 2}, {}}},
                                                       {"visibility", {{size_t{1} << 25, 0}, {}}}};
  CHECK(message_of([&] { tracks_from(long_and_empty, "t.npz", 10, 10); }).find("frames") != std::string::npos);
  write_file(folder / "t.json", R"({"tracks": [[[1,2]]], "visibility": [[2]]})");
  CHECK(message_of([&] { load_tracks(folder / "t.json", 10, 10); }).find("visibility") != std::string::npos);
}

TEST_CASE("eval: queries lie on the fixed grid, inside the mask eroded by one pixel") {
  Image mask(48, 48, 1);
  CHECK(query_pixels(mask).empty());
  std::fill(mask.pixels.begin(), mask.pixels.end(), uint8_t{255});
  REQUIRE(query_pixels(mask).size() == kGrid * kGrid);  // the nearest to the border is at 1: its neighbours exist
  CHECK(query_pixels(mask)[0].x == 1);
  *mask.at(0, 0) = 0;  // erosion takes the query at (1, 1) away
  CHECK(query_pixels(mask).size() == kGrid * kGrid - 1);
}

TEST_CASE("eval: masks hide points, and must fit the tracks") {
  const TemporaryFolder folder;
  Image mask(10, 10, 1);
  for (int y = 0; y < 10; ++y) *mask.at(4, y) = 255;
  save_png(folder / "masks/0.png", mask);
  save_png(folder / "masks/1.png", Image(10, 10, 1));
  const std::vector<Image> masks = load_masks(folder / "masks");
  CHECK(mask_areas(masks) == std::vector<long>{10, 0});
  Tracks tracks{10, 10, {{{4.5, 3}, {5.5, 3}}, {{4.5, 3}, {5.5, 3}}}, {{1, 1}, {1, 1}}};
  restrict_to_masks(tracks, masks, "masks");
  CHECK(tracks.visible == std::vector<std::vector<uint8_t>>{{1, 0}, {0, 0}});
  tracks.width = 11;
  CHECK(message_of([&] { restrict_to_masks(tracks, masks, "masks"); }).find("11 x 10") != std::string::npos);
  tracks.position.pop_back();
  CHECK(message_of([&] { restrict_to_masks(tracks, masks, "masks"); }).find("2 masks") != std::string::npos);
  CHECK_THROWS_AS(load_masks(folder / "none"), Error);
}

TEST_CASE("eval: optical flow follows a moving square, and loses what leaves the picture") {
  const TemporaryFolder folder;
  splat::VideoWriter writer(folder / "v.mp4", 96, 96, 25);
  for (int t = 0; t < 8; ++t) writer.write(square_frame(10 + 3 * t, 18));
  writer.finish();
  const Tracks tracks = track_by_flow(folder / "v.mp4", {{30, 40}, {40, 50}, {66, 40}});
  REQUIRE(tracks.frames() == 8);
  for (const int i : {0, 1}) {
    CHECK(tracks.visible[7][i] == 1);
    const Eigen::Vector2d moved = tracks.position[7][i] - tracks.position[0][i];
    // Lossy video and sub-pixel flow: a third of a pixel over 21.
    CHECK((moved - Eigen::Vector2d(21, 0)).norm() < 0.34);
  }
  splat::VideoWriter leaving(folder / "w.mp4", 96, 96, 25);
  for (int t = 0; t < 8; ++t) leaving.write(square_frame(10 + 8 * t, 18));
  leaving.finish();
  const Tracks gone = track_by_flow(folder / "w.mp4", {{66, 40}});
  CHECK(gone.visible[0][0] == 1);
  CHECK(gone.visible[7][0] == 0);
}

TEST_CASE("eval: CLIP similarity is the mean cosine, and a frame without direction is invalid") {
  // Cosines 1 and 0.6; lengths do not matter.
  CHECK(clip_similarity({{2, 0}, {{5, 0}, {3, 4}}}).value == doctest::Approx(0.8));
  CHECK(clip_similarity({{2, 0}, {{5, 0}, {0, 0}}}).reason.find("frame 1") != std::string::npos);
  CHECK_FALSE(clip_similarity({{0, 0}, {{5, 0}}}).valid);
  CHECK_FALSE(clip_similarity({{1, 0}, {}}).valid);
  CHECK_FALSE(clip_similarity({{1, 0}, {{std::nan(""), 1}}}).valid);
  const TemporaryFolder folder;
  write_file(folder / "e.json", R"({"text": [[2, 0]], "frames": [[5, 0], [3, 4]]})");
  CHECK(clip_similarity(load_clip_embeddings(folder / "e.json")).value == doctest::Approx(0.8));
  write_file(folder / "e.json", R"({"text": [2, 0, 0], "frames": [[5, 0], [3, 4]]})");
  CHECK(message_of([&] { load_clip_embeddings(folder / "e.json"); }).find("[T, 3]") != std::string::npos);
}

TEST_CASE("eval: CLIP's pictures are resampled, cropped and normalised") {
  // One colour stays that colour, normalised.
  Image flat(300, 500, 3);
  for (size_t i = 0; i < flat.pixels.size(); ++i) flat.pixels[i] = i % 3 == 0 ? 255 : 0;
  const std::vector<float> pixels = clip_pixels(flat);
  REQUIRE(pixels.size() == 3 * 224 * 224);
  CHECK(pixels[0] == doctest::Approx((1 - 0.48145466) / 0.26862954));
  CHECK(pixels[224 * 224] == doctest::Approx(-0.4578275 / 0.26130258));
  // A picture of 224 rows is only cropped: 28 columns go on either side.
  Image wide(280, 224, 3);
  for (int y = 0; y < 224; ++y) {
    for (int x = 0; x < 280; ++x) wide.at(x, y)[0] = static_cast<uint8_t>(x % 256);
  }
  const std::vector<float> cropped = clip_pixels(wide);
  CHECK(cropped[0] == doctest::Approx((28 / 255.0 - 0.48145466) / 0.26862954));
  CHECK(message_of([&] { clip_pixels(Image(4000, 2, 3)); }).find("4000 x 2") != std::string::npos);
  // A ramp stays one when it is halved: the middle of two columns.
  Image ramp(448, 448, 3);
  for (int y = 0; y < 448; ++y) {
    for (int x = 0; x < 448; ++x) ramp.at(x, y)[0] = static_cast<uint8_t>(x / 2);
  }
  CHECK(clip_pixels(ramp)[100 * 224 + 100] == doctest::Approx((100 / 255.0 - 0.48145466) / 0.26862954));
}

TEST_CASE("eval: CLIP's byte-pair encoding with a tiny merges file") {
  const TemporaryFolder folder;
  write_file(folder / "merges.txt", "#version: 0.2\nc a\nk e</w>\nca ke</w>\n");
  const ClipTokenizer tokenizer = load_clip_tokenizer(folder / "merges.txt");
  // 256 characters, 256 ends of words, 3 merges, start 515, end 516.
  const std::vector<int64_t> cake = tokenizer.encode("  Cake ");
  REQUIRE(cake.size() == kClipContext);
  CHECK(std::vector<int64_t>(cake.begin(), cake.begin() + 4) == std::vector<int64_t>{515, 514, 516, 0});
  // "a" ends a word: 'a' is the 65th printable byte, its end 256 further. "'s" is a word of its own; digits stand
  // alone.
  const int64_t a = 'a' - '!', end = 256;
  const std::vector<int64_t> ids = tokenizer.encode("a's 12!?");
  CHECK(
      std::vector<int64_t>(ids.begin() + 1, ids.begin() + 8) ==
      std::vector<int64_t>{a + end, '\'' - '!', 's' - '!' + end, '1' - '!' + end, '2' - '!' + end, 0, '?' - '!' + end});
  CHECK(ids[8] == 516);
  CHECK(message_of([&] { tokenizer.encode("gâteau"); }).find("ASCII") != std::string::npos);
  CHECK(message_of([&] { tokenizer.encode(std::string(80, '1')); }).find("80 tokens") != std::string::npos);
  write_file(folder / "merges.txt", "#version: 0.2\nc a k\n");
  CHECK(message_of([&] { load_clip_tokenizer(folder / "merges.txt"); }).find("line 2") != std::string::npos);
  write_file(folder / "merges.txt", "#version: 0.2\n");
  CHECK_THROWS_AS(load_clip_tokenizer(folder / "merges.txt"), Error);
}

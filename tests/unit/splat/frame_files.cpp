// Lists of frames, and a few of them on one page.
#include "splat/frame_files.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "scene/image_file.h"
#include "splat/contact_sheet.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

TEST_CASE("splat: lists of frames") {
  CHECK(splat::parse_frames("0", 1) == std::vector<int>{0});
  CHECK(splat::parse_frames("0,10,20-24", 25) == std::vector<int>{0, 10, 20, 21, 22, 23, 24});
  CHECK(splat::parse_frames("3,1,1,2-2", 4) == std::vector<int>{3, 1, 1, 2});  // as they are given
  for (const std::string list :
       {"", ",", "1,", ",1", "a", "-1", "1-", "3-2", "0,3-2", "25", "0-25", "1 2", "1-2-3", "9999999"}) {
    CHECK(message_of([&] { splat::parse_frames(list, 25); }, ExitCode::usage) ==
          "--frames: found \"" + list + "\", expected frame numbers and ranges below 25, such as 0,10,20-24");
  }
}

TEST_CASE("splat: a contact sheet keeps eight of many frames, the first and the last among them") {
  TemporaryFolder folder;
  // Frame i is a grey of level i; which were kept shows in the middle of each cell.
  const auto kept = [&](int frames) {
    splat::ContactSheet sheet(static_cast<size_t>(frames));
    for (int i = 0; i < frames; ++i) {
      Image image(40, 40, 3);
      image.pixels.assign(image.pixels.size(), static_cast<uint8_t>(i));
      sheet.add(static_cast<size_t>(i), i, image);
    }
    sheet.save(folder / "sheet.png");
    const Image page = load_image(folder / "sheet.png");
    // Cells of 40 x 40 pixels, gaps of 4, captions of 18 below: at most four in a row.
    const int columns = (page.width - 4) / 44, rows = (page.height - 4) / 62;
    CHECK(columns == std::min(frames, 4));
    std::vector<int> levels;
    for (int cell = 0; cell < columns * rows; ++cell) {
      const int level = page.at(24 + 44 * (cell % columns), 24 + 62 * (cell / columns))[0];
      if (level < frames) levels.push_back(level);
    }
    return levels;
  };
  CHECK(kept(50) == std::vector<int>{0, 7, 14, 21, 28, 35, 42, 49});
  CHECK(kept(8) == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(kept(3) == std::vector<int>{0, 1, 2});
  CHECK(kept(1) == std::vector<int>{0});
}

// The table of words: what it refuses, and that the program's own is read whole.
#include "plan/word_table.h"

#include <doctest/doctest.h>

#include "base/embedded_text.h"
#include "records/labels.h"
#include "unit/input_error.h"

using namespace physmas;
using namespace physmas::plan;

namespace {

std::string error(const std::string& text) {
  return message_of([&] { parse_word_table(text); }, ExitCode::internal);
}

const std::string& own() {
  static const std::string text = embedded_text("lib/plan/words/vocabulary.txt");
  return text;
}

}  // namespace

TEST_CASE("words: forms of verbs, directions and factors are what the table says") {
  REQUIRE(find_verb("threw"));
  CHECK(find_verb("threw")->lemma == "throw");
  CHECK(find_verb("throwing")->meaning.type == ActionType::translation);
  CHECK(find_verb("rose")->direction == "up");
  CHECK(find_verb("shrunk")->direction == "in");
  CHECK(find_verb("slumps")->meaning.kind == Meaning::Kind::gravity);
  CHECK(find_verb("bounced")->meaning.kind == Meaning::Kind::outcome);
  CHECK(find_verb("splashed")->meaning.kind == Meaning::Kind::not_modelled);
  CHECK(find_verb("splashed")->meaning.field == "liquid");
  CHECK(find_verb("topples")->meaning.tips);
  CHECK_FALSE(find_verb("think"));
  CHECK(find_region("headstock") == Region::top);
  CHECK(find_region("base") == Region::bottom);
  CHECK(find_region("cake") == Region::none);
  CHECK(find_material("wooden") == kWood);
  CHECK_FALSE(find_material("edge"));
  CHECK(replace_phrases({"after", "that", "it", "flies", "into", "the", "air"}) ==
        std::vector<std::string>{"then", "it", "flies", "upwards"});
  CHECK(find_direction("anticlockwise") == DirectionWord::counterclockwise);
  CHECK(find_direction("-y") == DirectionWord::minus_y);
  CHECK(find_direction("cake") == DirectionWord::none);
  CHECK(strength_factor("furiously") == 3);
  CHECK(strength_factor("delicately") == 0.5);
  CHECK(strength_factor("very") == 0);
  CHECK(intensifier("rather") == 0.7);
  CHECK(is_auxiliary("were"));
  CHECK(ends_clause(","));
  CHECK((is_wind("air") && is_external("air") && is_filler("air")));
  // Every action has a verb.
  std::set<ActionType> types;
  for (const auto& [form, verb] : word_table().verbs) {
    if (verb.meaning.kind == Meaning::Kind::action) types.insert(verb.meaning.type);
  }
  CHECK(types.size() == kActionCount);
}

TEST_CASE("words: a table that does not fit its description is refused by line") {
  CHECK(error(own()) == "no error");
  CHECK(error("\n# words\npush\n").find("line 3: the head") != std::string::npos);
  CHECK(error("[nouns]\ncake cake\n").find("line 2: [nouns] is no section that is known") != std::string::npos);
  const auto after = [](const std::string& section, const std::string& line) {
    std::string text = own();
    const size_t at = text.find(section + "\n");
    return error(text.insert(at + section.size() + 1, line + "\n"));
  };
  CHECK(after("[verbs]", "teleport - warp").find("does not know \"teleport\"") != std::string::npos);
  CHECK(after("[verbs]", "impulse sideways warp").find("the direction \"sideways\"") != std::string::npos);
  CHECK(after("[verbs]", "impulse -").find("an entry without words") != std::string::npos);
  CHECK(after("[verbs]", "impulse - warp warp").find("\"warp\" twice") != std::string::npos);
  CHECK(after("[verbs]", "impulse - push").find("\"push\" twice") != std::string::npos);
  CHECK(after("[verbs]", "impulse - warp:pushed").find("\"pushed\" of warp and of push") != std::string::npos);
  for (const char* forms : {"warp:", "warp::woorp", ":woorp"})
    CHECK(after("[verbs]", std::string("impulse - ") + forms).find("an empty form") != std::string::npos);
  CHECK(after("[directions]", "none nowhere").find("does not know \"none\"") != std::string::npos);
  CHECK(after("[directions]", "up left").find("\"left\" twice") != std::string::npos);
  for (const char* factor : {"much", "-1", "0", "2x", "nan", "1e9"})
    CHECK(after("[strengths]", std::string(factor) + " wildly").find("the factor") != std::string::npos);
  CHECK(after("[intensifiers]", "3 very").find("\"very\" twice") != std::string::npos);
  CHECK(after("[small words]", "adverb there").find("does not know \"adverb\"") != std::string::npos);
  CHECK(after("[small words]", "wind fan").find("\"fan\" twice") != std::string::npos);
  const size_t small = own().find("[small words]");
  CHECK(error(own().substr(0, small)).find("lacks a section") != std::string::npos);
}

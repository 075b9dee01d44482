// Sets, user preference rates and the paper's tables against closed forms.
#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>

#include "base/file.h"
#include "metrics/preference.h"
#include "metrics/study_page.h"
#include "records/json.h"
#include "tables/aggregate.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::tables;

namespace {

const std::vector<std::string> kProfiles = {"Jelly", "Metal", "Sand", "Foam", "Snow", "Plasticine"};

// Methods a and b; a case per profile, "two" with two profiles, and one of two objects.
Json manifest() {
  Json json = Json::parse(R"({"schema": "physmas/evaluation/1",
    "methods": [{"id": "alpha", "name": "Alpha & Co"}, {"id": "beta", "name": "Beta"}],
    "comparison": ["alpha", "beta"], "ablation": ["beta", "alpha"], "required": ["clip_sim"], "cases": []})");
  for (const std::string& profile : kProfiles) {
    std::string id = profile;
    for (char& c : id) c = static_cast<char>(std::tolower(c));
    json["cases"].push_back({{"id", id}, {"kind", "multi-part"}, {"prompt", "it <falls>"}, {"profiles", {profile}}});
  }
  json["cases"].push_back(
      {{"id", "two"}, {"kind", "multi-part"}, {"prompt", "it falls"}, {"profiles", {"Jelly", "Metal"}}});
  json["cases"].push_back(
      {{"id", "crash"}, {"kind", "multi-object"}, {"prompt", "they meet"}, {"objects", {"ball", "cup"}}});
  return json;
}

void write_metrics(const std::string& path, const std::string& target, const std::string& name, double value) {
  Json json = {{"schema", "physmas/metrics/1"}, {"target", target}};
  json["metrics"][name] = {{"status", "valid"}, {"value", value}, {"samples", 1}};
  write_file(path, json.dump());
}

// clip_sim of every result: 0.1 for alpha, 0.2 for beta, and 0.4 on "two" for both.
Json with_results(const TemporaryFolder& folder) {
  Json json = manifest();
  for (Json& c : json["cases"]) {
    for (const char* method : {"alpha", "beta"}) {
      const std::string id = c["id"], file = id + "-" + method + ".json";
      const bool alpha = std::string(method) == "alpha";
      write_metrics(folder / file, "scene", "clip_sim", id == "two" ? 0.4 : alpha ? 0.1 : 0.2);
      c["results"][method] = {{"status", "done"}, {"metrics", {file}}};
    }
  }
  return json;
}

Evaluation load(const TemporaryFolder& folder, const Json& json) {
  write_file(folder / "evaluation.json", json.dump());
  return load_evaluation(folder / "evaluation.json");
}

double number_in(const Table& table, size_t row, size_t column, size_t part = 0) {
  const Score& score = table.rows.at(row).cells.at(column).numbers.at(part).score;
  REQUIRE(score.valid());
  return score.value;
}

StudyAnswers answers_of(const std::string& respondent, const StudyKey& key, const std::string& method) {
  StudyAnswers answers;
  answers.respondent = respondent;
  for (const StudyKey::Case& c : key.cases) answers.answers.push_back({c.id, method});
  return answers;
}

const Preference& rate(const UprRecord& record, const std::string& set, const std::string& method) {
  for (const UprRecord::Set& s : record.sets) {
    if (s.name == set) return s.upr.at(method);
  }
  FAIL("no set " << set);
  throw 0;
}

}  // namespace

TEST_CASE("eval: a case of several profiles enters each, and the average is of the six profiles, not of the cases") {
  const TemporaryFolder folder;
  const Evaluation evaluation = load(folder, with_results(folder));
  const Aggregate aggregate(evaluation, {});
  const Table table = aggregate.paper_tables()[0];
  CHECK(number_in(table, 0, 0) == doctest::Approx(0.25));  // Jelly: 0.1 and 0.4
  CHECK(number_in(table, 0, 2) == doctest::Approx(0.25));  // Metal, too
  CHECK(number_in(table, 0, 4) == doctest::Approx(0.1));
  CHECK(number_in(table, 0, 12) == doctest::Approx((0.25 + 0.25 + 4 * 0.1) / 6));
  CHECK(table.rows[1].cells[4].numbers[0].best);
  CHECK_FALSE(table.rows[0].cells[4].numbers[0].best);
  CHECK(number_in(aggregate.paper_tables()[1], 1, 0) == doctest::Approx(0.2));  // multi-object
  CHECK(aggregate.lacking().empty());
  // Table 5 has the methods side by side, in the ablation's order.
  const Table ablation = aggregate.paper_tables()[4];
  CHECK(ablation.columns[0].group == "Beta");
  CHECK(number_in(ablation, 2, 0) == doctest::Approx(0.2));
  CHECK(ablation.rows[2].cells[0].numbers[0].best);
}

TEST_CASE("eval: a failure is a row, makes its sets invalid, and is never dropped") {
  const TemporaryFolder folder;
  Json json = with_results(folder);
  json["cases"][2]["results"]["alpha"] = {{"status", "failed"}, {"reason", "diverged"}};  // Sand
  json["cases"][3]["results"].erase("alpha");                                             // Foam: no result at all
  const Evaluation evaluation = load(folder, json);
  const Aggregate aggregate(evaluation, {});
  REQUIRE(aggregate.lacking().size() == 2);
  CHECK(aggregate.lacking()[0] == "sand, alpha: clip_sim: failed: diverged");
  CHECK(aggregate.lacking()[1] == "foam, alpha: clip_sim: failed: no result");
  const Table cases = aggregate.case_table();
  CHECK(cases.rows.size() == 16);
  CHECK(cases.csv().find("sand,Sand,alpha,failed,,,,,,,,diverged") != std::string::npos);
  const Table table = aggregate.paper_tables()[0];
  CHECK(table.rows[0].cells[4].numbers[0].text() == "invalid");
  CHECK(table.rows[0].cells[12].numbers[0].text() == "invalid");
  CHECK_FALSE(table.rows[1].cells[4].numbers[0].best);  // nobody is known to be best
  CHECK(number_in(table, 0, 0) == doctest::Approx(0.25));
}

TEST_CASE("eval: objects of a scene count alike, and each must be there") {
  const TemporaryFolder folder;
  Json json = with_results(folder);
  write_metrics(folder / "ball.json", "ball", "strain_rmse", 3);
  write_metrics(folder / "cup.json", "cup", "strain_rmse", 7);
  json["cases"][7]["results"]["alpha"]["metrics"] = {"ball.json", "cup.json"};
  json["cases"][7]["results"]["beta"]["metrics"] = {"ball.json"};
  json["required"] = {"strain_rmse"};
  const Evaluation evaluation = load(folder, json);
  const Aggregate aggregate(evaluation, {});
  const Table motion = aggregate.paper_tables()[3];
  CHECK(number_in(motion, 0, 2, 1) == doctest::Approx(5));
  CHECK(motion.rows[1].cells[2].numbers[1].text() == "invalid");
  const auto lacking = aggregate.lacking();
  CHECK(std::find(lacking.begin(), lacking.end(), "crash, beta: strain_rmse: no record of the object cup") !=
        lacking.end());
  json["cases"][7]["results"]["alpha"]["metrics"] = {"ball.json", "ball-again.json"};
  write_metrics(folder / "ball-again.json", "ball", "strain_rmse", 9);
  const Evaluation twice = load(folder, json);
  CHECK(message_of([&] { Aggregate(twice, {}); }).find("second record") != std::string::npos);
}

TEST_CASE("eval: a set without a case is a dash, not a zero") {
  const TemporaryFolder folder;
  Json json = with_results(folder);
  json["cases"].erase(4);  // Snow
  const Evaluation evaluation = load(folder, json);
  const Table table = Aggregate(evaluation, {}).paper_tables()[0];
  CHECK(table.rows[0].cells[8].numbers[0].text() == "–");
  CHECK(table.rows[0].cells[12].numbers[0].text() == "–");
}

TEST_CASE("eval: a manifest that does not hold together is refused") {
  const TemporaryFolder folder;
  const auto refused = [&](const char* pointer, const Json& value) {
    Json json = with_results(folder);
    json[Json::json_pointer(pointer)] = value;
    return message_of([&] { load(folder, json); });
  };
  CHECK(refused("/comparison", {"alpha", "gamma"}).find("/comparison/1") != std::string::npos);
  CHECK(refused("/cases/1/id", "jelly").find("/cases/1/id") != std::string::npos);
  CHECK(refused("/methods/1/id", "alpha").find("/methods/1/id") != std::string::npos);
  CHECK(refused("/cases/7/profiles", {"Jelly"}).find("/cases/7/profiles") != std::string::npos);
  CHECK(refused("/cases/0/objects", {"ball"}).find("/cases/0/objects") != std::string::npos);
  CHECK(refused("/cases/0/results/gamma", {{"status", "done"}}).find("gamma") != std::string::npos);
  CHECK(refused("/cases/0/results/alpha/metrics", {"../x.json"}).find("../x.json") != std::string::npos);
}

TEST_CASE("eval: tables escape what their format reads") {
  const TemporaryFolder folder;
  const Evaluation evaluation = load(folder, with_results(folder));
  Table table = Aggregate(evaluation, {}).paper_tables()[1];
  CHECK(table.latex().find("Alpha \\& Co & 0.1000 & –") != std::string::npos);
  CHECK(table.latex().find("\\textbf{0.2000}") != std::string::npos);
  CHECK(table.latex().find("CLIP$_{sim}$ & UPR") != std::string::npos);
  // The last method, ours by custom, stands below a rule.
  CHECK(table.latex().rfind("\\midrule") > table.latex().find("Alpha"));
  table.rows[0].label = "=a|b,\"c\"";
  CHECK(table.markdown().find("=a\\|b") != std::string::npos);
  // Raw HTML, emphasis, links, code; what a terminal would obey.
  table.rows[1].label = "<img src=x>*b*[c](d)`e`\x1b[31m\xc2\x9b\n\xe2\x80\xae";
  CHECK(table.markdown().find("| &lt;img src=x&gt;\\*b\\*\\[c\\](d)\\`e\\` \\[31m? ? |") != std::string::npos);
  for (const std::string& text : {table.markdown(), table.latex(), table.csv()}) {
    CHECK(text.find('\x1b') == std::string::npos);
    CHECK(text.find("\xc2\x9b") == std::string::npos);
    CHECK(text.find("\xe2\x80\xae") == std::string::npos);
  }
  CHECK(table.csv().find("\"'=a|b,\"\"c\"\"\",0.1,") != std::string::npos);
}

TEST_CASE("eval: preference rates weigh cases, not responses") {
  const TemporaryFolder folder;
  const Evaluation evaluation = load(folder, with_results(folder));
  const StudyKey key = metrics::make_study(evaluation, "comparison", "1");
  std::vector<StudyAnswers> answers = {answers_of("1", key, "alpha"), answers_of("2", key, "alpha"),
                                       answers_of("3", key, "alpha"), answers_of("4", key, "beta")};
  // Respondents 1 and 2 did not answer the case "jelly": there it is 1 to 1.
  for (int h : {0, 1}) answers[h].answers.erase(answers[h].answers.begin());
  const UprRecord record = metrics::preference_rates(key, answers, 500, 7);
  CHECK(record.cases[0].responses == 2);
  CHECK(rate(record, "Jelly", "alpha").value == doctest::Approx((50 + 75) / 2.0));
  CHECK(rate(record, "multi-object", "alpha").value == doctest::Approx(75));
  CHECK(rate(record, "average", "beta").value == doctest::Approx((37.5 + 5 * 25) / 6));
  for (const UprRecord::Set& set : record.sets) {
    for (const auto& [method, p] : set.upr) {
      CHECK(p.low <= p.value);
      CHECK(p.value <= p.high);
      CHECK(p.low >= 0);
      CHECK(p.high <= 100);
    }
  }
  CHECK(rate(record, "Sand", "alpha").low < 75);
  // Fixed seed, fixed interval.
  CHECK(rate(metrics::preference_rates(key, answers, 500, 7), "Jelly", "alpha").low ==
        rate(record, "Jelly", "alpha").low);
  // All of one mind: no spread.
  const UprRecord same = metrics::preference_rates(key, {answers[2], answers_of("5", key, "alpha")}, 100, 0);
  CHECK(rate(same, "average", "alpha").low == 100);
  CHECK(message_of([&] { metrics::preference_rates(key, {answers[0]}, 10, 0); }).find("jelly") != std::string::npos);

  // Rates enter the tables through the counts.
  const Table table = Aggregate(evaluation, {record}).paper_tables()[0];
  CHECK(number_in(table, 0, 1) == doctest::Approx(62.5));
  CHECK(table.rows[0].cells[5].numbers[0].text() == "75%");
}

TEST_CASE("eval: the interval of a preference rate is the bootstrap's from 2.5 to 97.5 %") {
  StudyKey key;
  key.methods = {"alpha", "beta"};
  key.cases.push_back({"one", true, {}, {}});
  std::vector<StudyAnswers> answers;
  for (int h = 0; h < 100; ++h) answers.push_back(answers_of(std::to_string(h), key, h < 50 ? "alpha" : "beta"));
  // A resample's count is binomial with n = 100 and p = 0.5: quantiles 40 and 60; 42 and 58 are those of 5 and 95 %.
  const Preference p = rate(metrics::preference_rates(key, answers, 10000, 1), "multi-object", "alpha");
  CHECK(p.value == 50);
  CHECK(p.low == doctest::Approx(40).epsilon(0.02));
  CHECK(p.high == doctest::Approx(60).epsilon(0.015));
}

TEST_CASE("eval: answers must fit the key") {
  const TemporaryFolder folder;
  const Evaluation evaluation = load(folder, with_results(folder));
  const StudyKey key = metrics::make_study(evaluation, "comparison", "1");
  const auto codes = key.cases[0].codes;
  const std::string first = codes.begin()->first, second = codes.rbegin()->first;
  const auto message = [&](const std::string& token, const std::string& id, const Json& order,
                           const std::string& choice, int times = 1) {
    Json json = {{"schema", "physmas/answers/1"}, {"token", token}, {"respondent", "x"}, {"answers", Json::array()}};
    for (int i = 0; i < times; ++i) json["answers"].push_back({{"case", id}, {"order", order}, {"choice", choice}});
    write_file(folder / "a.json", json.dump());
    return message_of([&] { load_study_answers(folder / "a.json", key); });
  };
  CHECK(message(key.token, "jelly", {first, second}, second) == "no error");
  CHECK(message(std::string(64, '0'), "jelly", {first, second}, second).find("another study") != std::string::npos);
  CHECK(message(key.token, "soup", {first, second}, second).find("/answers/0/case") != std::string::npos);
  CHECK(message(key.token, "jelly", {first, second}, second, 2).find("/answers/1/case") != std::string::npos);
  CHECK(message(key.token, "jelly", {first, first}, first).find("/order") != std::string::npos);
  CHECK(message(key.token, "jelly", {first, second}, "alpha").find("/choice") != std::string::npos);
  CHECK(metrics::make_study(evaluation, "comparison", "2").token != key.token);
}

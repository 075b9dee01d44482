#include "remote/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "base/clock.h"
#include "base/output.h"
#include "records/json.h"
#include "remote/address.h"
#include "remote/chat.h"
#include "remote/inference.h"
#include "remote/request_files.h"
#include "scene/image_file.h"

namespace physmas::remote {
namespace {

constexpr int kPictureSize = 64;  // pixels

// What a run asks of a model, by the names of its tensors. The test picture is kPictureSize pixels wide and high.
struct Role {
  const char* title;
  const char* variable;  // of make; empty: a flag of pm-eval
  std::vector<InputTensor> inputs;
  std::vector<TensorSpecification> outputs;
};

std::string red_picture() {
  Image image;
  image.width = image.height = kPictureSize;
  image.pixels.resize(size_t{3} * kPictureSize * kPictureSize);
  for (size_t i = 0; i < image.pixels.size(); i += 3) image.pixels[i] = 255;
  return encode_png(image);
}

std::vector<Role> roles() {
  const std::string png = red_picture();
  const double edge = kPictureSize - 4;
  const long size = kPictureSize;
  const InputTensor tokens{"input_ids", {1, 77}, {}, {}, std::vector<double>(77, 49407), true};
  const InputTensor pixels{"pixel_values", {1, 3, 224, 224}, {}, {}, std::vector<double>(size_t{3} * 224 * 224, 0.1)};
  const InputTensor queries{"queries", {1, 1, 3}, {}, {}, {0, 8, 8}};
  return {{"detector",
           "PERCEPTION",
           {{"image", {1}, {png}, {}, {}}, {"prompt", {1}, {}, {"red square"}, {}}},
           {{"boxes", {-1, 4}}, {"scores", {-1}}, {"phrases", {-1}}}},
          {"segmenter",
           "PERCEPTION",
           {{"image", {1}, {png}, {}, {}}, {"boxes", {1, 4}, {}, {}, {4, 4, edge, edge}}},
           {{"masks", {1, size, size}}, {"scores", {1}}}},
          {"predictor",
           "PREDICTOR",
           {{"crops", {1}, {png}, {}, {}}},
           {{"E_mean", {1}, true},
            {"E_uncertainty", {1}, true},
            {"nu_mean", {1}, true},
            {"nu_uncertainty", {1}, true},
            {"label_evidence", {1, 14}, true}}},
          {"text encoder", "", {tokens}, {{"text_embeds", {1, -1}}}},
          {"image encoder", "", {pixels}, {{"image_embeds", {1, -1}}}},
          {"tracker",
           "",
           {{"frames", {2}, {png, png}, {}, {}}, queries},
           {{"tracks", {1, 2, 1, 2}}, {"visibility", {1, 2, 1}}}}};
}

class Checker {
 public:
  explicit Checker(const CheckOptions& options) : options_(options), url_(parse_url(options.url, "check")) {}

  bool check() {
    print("{}{}{}\n", url_.origin, url_.path, url_.query);
    const bool names_inference = url_.path.find("/v2") != std::string::npos;
    if (names_inference || (url_.path.empty() && speaks_inference())) {
      check_inference();
    } else {
      check_chat();
    }
    return works_;
  }

 private:
  void say(const char* mark, const std::string& what, const std::string& found) {
    print("  {:<5} {:<18} {}\n", mark, what, one_line(found, 160));
  }
  void good(const std::string& what, const std::string& found) { say("ok", what, found); }
  void note(const std::string& what, const std::string& found) { say("note", what, found); }
  void bad(const std::string& what, const std::string& found) {
    say("no", what, found);
    works_ = false;
  }
  // Runs a part of the conversation; whether it did not fail.
  bool tries(const std::string& what, const std::function<void()>& part) {
    try {
      part();
      return true;
    } catch (const Error& e) {
      if (e.code() != ExitCode::provider_failed) throw;
      bad(what, e.what());
      return false;
    }
  }

  std::unique_ptr<Backend> open(const std::string& path) const {
    return open_backend(url_.origin + path + url_.query, "check", "", options_.remote);
  }
  // GET below `path`; any status is an answer.
  Reply get(const std::string& path, bool wants_json = true) const {
    Request request;
    request.name = "check";
    request.method = "GET";
    request.wants_json = wants_json;
    request.returned_statuses = {400, 401, 403, 404, 405, 422, 500, 501};
    return open(path)->exchange(request);
  }

  bool speaks_inference() const { return get("/v2/health/ready", false).status == 200; }

  // --- Open Inference Protocol --------------------------------------------------------------------------------------

  void check_inference() {
    const std::string server = path_of_server(url_.path.empty() ? "/v2/models" : url_.path);
    const std::string models = server + "/v2/models";
    tries("server", [&] {
      const Reply reply = get(server + "/v2");
      const auto text = [&](const char* field) {
        const Json value = reply.body.is_object() ? reply.body.value(field, Json()) : Json();
        return value.is_string() ? value.get<std::string>() : std::string();
      };
      const bool binary = reply.body.dump().find("binary_tensor_data") != std::string::npos;
      good("server", fmt::format("{} {}, {} the binary tensor extension", text("name"), text("version"),
                                 binary ? "with" : "without"));
    });
    const bool names_model =
        url_.path.size() > models.size() && url_.path.compare(0, models.size() + 1, models + "/") == 0;
    const std::vector<Role> all = roles();
    if (names_model) {
      check_model(url_.path, nullptr);
    } else {
      check_model(models + "/" + options_.detector, &all[0]);
      check_model(models + "/" + options_.segmenter, &all[1]);
      if (works_) good("run", "make run ... PERCEPTION=" + options_.url);
    }
  }

  // role: what the model shall be; null where its metadata have to say.
  void check_model(const std::string& path, const Role* role) {
    const std::string name = path.substr(path.rfind('/') + 1);
    const std::vector<Role> all = roles();
    tries(name, [&] {
      if (role == nullptr) {
        const Json metadata = get(path).body;
        role = role_of(metadata, all);
        if (role == nullptr) {
          role = &role_by_name(name, all);
          const bool silent = declared_tensors(metadata, "inputs").empty();
          note(name, fmt::format("{}; tried as a {}",
                                 silent ? "says nothing of its tensors" : "has other tensors than a run asks for",
                                 role->title));
        }
      }
      const auto backend = open(path);
      InferenceClient client(*backend, "check", tensor_form(options_.remote.tensors));
      std::vector<std::string> inputs, outputs;
      for (const InputTensor& input : role->inputs) inputs.push_back(input.name);
      for (const TensorSpecification& output : role->outputs) outputs.push_back(output.name);
      client.require_model(inputs, outputs);
      good(name, fmt::format("is ready, as a {}", role->title));
      const Stopwatch watch;
      const auto found = client.infer("trial", role->inputs, role->outputs);
      std::vector<std::string> shapes;
      for (const auto& [output, tensor] : found)
        shapes.push_back(fmt::format("{} [{}]", output, fmt::join(tensor.shape, ", ")));
      good(name, fmt::format("answers in {:.1f} s{}: {}", watch.seconds(), client.is_binary() ? ", in binary" : "",
                             fmt::join(shapes, ", ")));
      if (url_.path == path && *role->variable != 0)
        good("run", fmt::format("make run ... {}={}", role->variable, options_.url));
    });
  }

  // Where its tensors do not say: "clip-text", "cotracker3".
  static const Role& role_by_name(const std::string& name, const std::vector<Role>& all) {
    const std::pair<const char*, size_t> parts[] = {{"text", 3}, {"image", 4},  {"vision", 4}, {"track", 5},
                                                    {"dino", 0}, {"detect", 0}, {"sam", 1},    {"segment", 1}};
    for (const auto& [part, role] : parts) {
      if (name.find(part) != std::string::npos) return all[role];
    }
    return all[2];
  }

  static const Role* role_of(const Json& metadata, const std::vector<Role>& all) {
    const auto has = [](const std::vector<DeclaredTensor>& declared, const std::string& name) {
      return std::any_of(declared.begin(), declared.end(), [&](const DeclaredTensor& t) { return t.name == name; });
    };
    const std::vector<DeclaredTensor> inputs = declared_tensors(metadata, "inputs");
    const auto found = std::find_if(all.begin(), all.end(), [&](const Role& role) {
      return std::all_of(role.inputs.begin(), role.inputs.end(),
                         [&](const InputTensor& t) { return has(inputs, t.name); });
    });
    return found == all.end() ? nullptr : &*found;
  }

  // --- Chat completions ---------------------------------------------------------------------------------------------

  void check_chat() {
    if (url_.path.empty()) url_.path = "/v1";
    std::string model = options_.model;
    tries("models", [&] {
      const Reply reply = get(url_.path + "/models");
      if (reply.status == 401 || reply.status == 403) {
        bad("key", fmt::format("HTTP {}: {}; is PM_API_KEY set to a valid key?", reply.status, words_of(reply.said)));
        return;
      }
      std::vector<std::string> names;
      const Json list = reply.body.is_object() ? reply.body.value("data", Json()) : Json();
      for (const Json& entry : list.is_array() ? list : Json::array()) {
        if (entry.is_object() && entry.value("id", Json()).is_string())
          names.push_back(entry.at("id").get<std::string>());
      }
      const std::string shown =
          fmt::format("{}", fmt::join(names.begin(), names.begin() + std::min<long>(5, names.size()), ", "));
      if (names.empty()) {
        note("models", fmt::format("no list of models (HTTP {})", reply.status));
      } else if (model.empty()) {
        model = names.front();
        good("models", shown + (names.size() > 1 ? "; the first is asked, --model NAME names another" : ""));
      } else if (std::find(names.begin(), names.end(), model) == names.end()) {
        note("models", fmt::format("{} is not among {}", model, shown));
      } else {
        good("models", shown);
      }
    });
    if (!works_) return;
    if (model.empty()) {
      bad("model", "expected --model NAME: the server does not name one");
      return;
    }
    const auto backend = open(url_.path);
    ChatClient chat(*backend, model, load_body_fields(options_.remote.body));
    Question question;
    question.name = "check_text";
    question.instructions = "You answer test questions of a program with a colour.";
    question.text = "The question: which colour has the sky on a clear day?";
    question.schema = "check_reply";
    const auto asks = [&](const std::string& what) {
      Answer answer;
      const Stopwatch watch;
      const bool answered = tries(what, [&] { answer = chat.ask(question); });
      seconds_ = watch.seconds();
      return answered ? std::optional<Answer>(answer) : std::nullopt;
    };
    if (const auto answer = asks("text"))
      good("text", fmt::format("answers in {:.1f} s{}", seconds_, rejected(*answer)));
    if (!works_) return;
    tell_manner(chat.manner());
    question.name = "check_picture";
    question.text = "The question: which colour has the picture? \"none\" if you see no picture.";
    question.images = {red_picture()};
    if (const auto answer = asks("pictures")) {
      const std::string color = answer->json.at("color").get<std::string>();
      const std::string took = fmt::format("answers in {:.1f} s", seconds_);
      if (color == "red") {
        good("pictures", took + ": a red one is red");
      } else {
        note("pictures", took + ", but calls a red one \"" + color + "\": does the model see?");
      }
    }
    question.name = "check_correction";
    question.images.clear();
    question.text = "The question: which colour has grass?";
    bool first = true;
    question.reject = [&](const Json&) {
      const bool is_first = first;
      first = false;
      return is_first ? std::string("a test: say it once more") : std::string();
    };
    if (asks("corrections")) good("corrections", "a rejected answer is asked for once more");
    if (works_)
      good("run", fmt::format("make run ... AGENT={} SCENE_AGENT={} MODEL={}", options_.url, options_.url, model));
  }

  static std::string rejected(const Answer& answer) {
    return answer.rejected.empty() ? "" : "; at the second try: " + answer.rejected.front();
  }

  void tell_manner(const Manner& manner) {
    using Structure = Manner::Structure;
    if (manner.structure == Structure::json_schema) {
      good("structured output", "json_schema is taken");
    } else if (manner.structure == Structure::json_object) {
      note("structured output", "json_schema is refused, json_object is taken; the schema stands in the text");
    } else {
      note("structured output", "refused; the schema stands in the text, answers may need a second try");
    }
    std::vector<std::string> left;
    if (!manner.temperature) left.push_back("temperature 0 is refused and left out");
    if (!manner.system) left.push_back("system messages are refused; they go in front of the question");
    if (manner.thinking == Manner::Thinking::off) left.push_back("thinking is turned off");
    if (!manner.length.empty()) left.push_back("the limit is called " + manner.length);
    for (const std::string& what : left) note("manner", what);
  }

  const CheckOptions& options_;
  Url url_;
  bool works_ = true;
  double seconds_ = 0;
};

}  // namespace

bool check_server(const CheckOptions& options) {
  return Checker(options).check();
}

}  // namespace physmas::remote

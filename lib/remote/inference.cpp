#include "remote/inference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "records/json.h"

namespace physmas::remote {
namespace {

constexpr long kMaxElements = 1 << 26;
constexpr size_t kReplyLimit = size_t{64} << 20;  // tensors as JSON text are long

// Appends the numbers of flat or nested `data`.
void flatten(const Json& data, Tensor& tensor, const std::string& source, const std::string& field) {
  if (data.is_array()) {
    for (const Json& part : data) flatten(part, tensor, source, field);
  } else if (tensor.datatype == "BYTES") {
    if (!data.is_string())
      throw provider_error(source, field + "/data: found " + one_line(data.dump(), 60) + ", expected texts");
    tensor.texts.push_back(data.get<std::string>());
  } else if (data.is_number()) {
    tensor.numbers.push_back(data.get<double>());
  } else if (data.is_boolean()) {
    tensor.numbers.push_back(data.get<bool>() ? 1 : 0);
  } else if (data.is_null()) {
    tensor.numbers.push_back(std::numeric_limits<double>::quiet_NaN());
  } else {
    throw provider_error(source, field + "/data: found " + one_line(data.dump(), 60) + ", expected numbers");
  }
}

bool fits(const std::vector<long>& shape, const std::vector<long>& wanted) {
  return shape.size() == wanted.size() &&
         std::equal(shape.begin(), shape.end(), wanted.begin(), [](long a, long b) { return b < 0 || a == b; });
}

std::vector<std::string> names_in(const Json& metadata, const char* field) {
  std::vector<std::string> names;
  if (!metadata.is_object() || !metadata.contains(field) || !metadata.at(field).is_array()) return names;
  for (const Json& entry : metadata.at(field)) {
    if (entry.is_object() && entry.contains("name") && entry.at("name").is_string())
      names.push_back(entry.at("name").get<std::string>());
  }
  return names;
}

Tensor tensor_from(const Json& output, const TensorSpecification& wanted, const std::string& source) {
  const std::string field = "/outputs/" + wanted.name;
  const auto bad = [&](const std::string& what) { return provider_error(source, field + what); };
  Tensor tensor;
  if (!output.contains("datatype") || !output.at("datatype").is_string()) throw bad("/datatype: found none");
  tensor.datatype = output.at("datatype").get<std::string>();
  if (!output.contains("shape") || !output.at("shape").is_array()) throw bad("/shape: found none");
  long elements = 1;
  for (const Json& extent : output.at("shape")) {
    if (!extent.is_number_integer() || extent.get<long>() < 0 || extent.get<long>() > kMaxElements)
      throw bad("/shape: found " + one_line(extent.dump(), 40) + ", expected extents of at most 2^26");
    tensor.shape.push_back(extent.get<long>());
    elements *= tensor.shape.back();
    if (elements > kMaxElements) throw bad("/shape: found more than 2^26 elements");
  }
  // Servers write a batch of single numbers as [N, 1], too (MLServer's codec does).
  while (tensor.shape.size() > wanted.shape.size() && tensor.shape.back() == 1) tensor.shape.pop_back();
  if (!fits(tensor.shape, wanted.shape))
    throw bad(
        fmt::format("/shape: found [{}], expected [{}]", fmt::join(tensor.shape, ", "), fmt::join(wanted.shape, ", ")));
  if (!output.contains("data"))
    throw bad("/data: found none, expected JSON numbers (the binary extension is not asked for)");
  flatten(output.at("data"), tensor, source, field);
  const size_t found = tensor.numbers.size() + tensor.texts.size();
  if (static_cast<long>(found) != elements)
    throw bad(fmt::format("/data: found {} {}, expected {}", found, tensor.datatype == "BYTES" ? "texts" : "numbers",
                          elements));
  return tensor;
}

}  // namespace

std::map<std::string, Tensor> tensors_from(const Json& reply, const std::vector<TensorSpecification>& outputs,
                                           const std::string& source) {
  if (!reply.is_object() || !reply.contains("outputs") || !reply.at("outputs").is_array())
    throw provider_error(source, "/outputs: found none, expected a v2 inference reply");
  std::map<std::string, Tensor> tensors;
  for (const TensorSpecification& wanted : outputs) {
    const Json* found = nullptr;
    for (const Json& output : reply.at("outputs")) {
      if (output.is_object() && output.value("name", Json()) == wanted.name) found = &output;
    }
    if (found == nullptr) throw provider_error(source, "/outputs: found no output named \"" + wanted.name + "\"");
    tensors[wanted.name] = tensor_from(*found, wanted, source);
  }
  return tensors;
}

InferenceClient::InferenceClient(Backend& backend, std::string name) : backend_(backend), name_(std::move(name)) {}

void InferenceClient::require_model(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  Request ready;
  ready.name = name_ + "_ready";
  ready.method = "GET";
  ready.path = "/ready";
  ready.wants_json = false;
  backend_.exchange(ready);
  Request metadata;
  metadata.name = name_ + "_metadata";
  metadata.method = "GET";
  const Reply reply = backend_.exchange(metadata);
  const auto require = [&](const char* field, const std::vector<std::string>& wanted) {
    const std::vector<std::string> offered = names_in(reply.body, field);
    for (const std::string& name : wanted) {
      if (std::find(offered.begin(), offered.end(), name) != offered.end()) continue;
      throw provider_error(metadata.name,
                           fmt::format("/{}: found \"{}\", expected \"{}\" among them", field,
                                       one_line(fmt::format("{}", fmt::join(offered, "\", \"")), 200), name));
    }
  };
  require("inputs", inputs);
  require("outputs", outputs);
}

std::map<std::string, Tensor> InferenceClient::infer(const std::string& name, const std::vector<InputTensor>& inputs,
                                                     const std::vector<TensorSpecification>& outputs) {
  Request request;
  request.name = name_ + "_" + name;
  request.method = "POST";
  request.path = "/infer";
  request.reply_limit = kReplyLimit;
  request.body["inputs"] = Json::array();
  for (const InputTensor& input : inputs) {
    const char* datatype = input.numbers.empty() ? "BYTES" : input.whole ? "INT64" : "FP32";
    Json tensor = {{"name", input.name}, {"shape", input.shape}, {"datatype", datatype}};
    if (input.numbers.empty()) tensor["parameters"] = {{"content_type", input.png_files.empty() ? "str" : "base64"}};
    tensor["data"] = Json::array();
    for (const double number : input.numbers) {
      tensor["data"].push_back(input.whole ? Json(static_cast<std::int64_t>(number)) : Json(number));
    }
    for (const std::string& text : input.texts) tensor["data"].push_back(text);
    for (const std::string& png : input.png_files) {
      const std::string place = fmt::format("/inputs/{}/data/{}", request.body["inputs"].size(), tensor["data"].size());
      tensor["data"].push_back("");
      request.attachments.push_back({place, "", png, "png"});
    }
    request.body["inputs"].push_back(tensor);
  }
  request.body["outputs"] = Json::array();
  for (const TensorSpecification& output : outputs) request.body["outputs"].push_back({{"name", output.name}});
  return tensors_from(backend_.exchange(request).body, outputs, request.name);
}

}  // namespace physmas::remote

#include "remote/inference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "records/json.h"
#include "remote/tensor_bytes.h"

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

// The shape without extents of 1 in front or behind, or with those in front that are wanted, so that it fits; as it is
// where none does. Those behind go first: MLServer's codec writes [N] as [N, 1].
std::vector<long> fitted(const std::vector<long>& shape, const std::vector<long>& wanted) {
  size_t ones = 0;
  while (ones < wanted.size() && wanted[ones] == 1) ++ones;
  for (size_t added = 0; added <= ones; ++added) {
    for (size_t front = 0; front <= shape.size() && (front == 0 || shape[front - 1] == 1); ++front) {
      std::vector<long> rest(added, 1);
      rest.insert(rest.end(), shape.begin() + static_cast<long>(front), shape.end());
      for (;;) {
        if (fits(rest, wanted)) return rest;
        if (rest.empty() || rest.back() != 1) break;
        rest.pop_back();
      }
    }
  }
  return shape;
}

// How many bytes of an output lie behind the JSON; nothing where it is in the JSON.
std::optional<size_t> binary_size(const Json& output, const std::string& field, const std::string& source) {
  if (!output.is_object() || !output.contains("parameters") || !output.at("parameters").is_object())
    return std::nullopt;
  const Json& parameters = output.at("parameters");
  if (!parameters.contains("binary_data_size")) return std::nullopt;
  const Json& size = parameters.at("binary_data_size");
  if (!size.is_number_unsigned() || size.get<size_t>() > kReplyLimit) {
    throw provider_error(source, field + "/parameters/binary_data_size: found " + one_line(size.dump(), 40) +
                                     ", expected a number of bytes");
  }
  return size.get<size_t>();
}

Tensor tensor_from(const Json& output, const TensorSpecification& wanted, const std::string& source,
                   const std::optional<std::string>& bytes) {
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
  const std::vector<long> found_shape = tensor.shape;
  tensor.shape = fitted(tensor.shape, wanted.shape);
  if (!fits(tensor.shape, wanted.shape))
    throw bad(
        fmt::format("/shape: found [{}], expected [{}]", fmt::join(found_shape, ", "), fmt::join(wanted.shape, ", ")));
  const bool is_text = tensor.datatype == "BYTES";
  if (bytes) {
    const size_t size = element_size(tensor.datatype);
    if (!is_text && size == 0)
      throw bad("/datatype: found " + one_line(tensor.datatype, 40) + ", expected one of the protocol's");
    if (!is_text && bytes->size() != static_cast<size_t>(elements) * size)
      throw bad(fmt::format("/parameters/binary_data_size: found {} bytes, expected {}", bytes->size(),
                            static_cast<size_t>(elements) * size));
    if (!is_text) tensor.numbers = numbers_in(*bytes, tensor.datatype);
    if (is_text && !texts_in(*bytes, tensor.texts)) throw bad(": found a text that does not end within its bytes");
    for (double& x : tensor.numbers) x = std::isfinite(x) ? x : std::numeric_limits<double>::quiet_NaN();
  } else if (output.contains("data")) {
    flatten(output.at("data"), tensor, source, field);
  } else {
    throw bad("/data: found none, expected JSON numbers; --tensors binary asks for the binary extension");
  }
  const size_t found = tensor.numbers.size() + tensor.texts.size();
  if (static_cast<long>(found) != elements)
    throw bad(fmt::format("/data: found {} {}, expected {}", found, is_text ? "texts" : "numbers", elements));
  if (!wanted.may_be_missing) {
    const auto nan = std::find_if(tensor.numbers.begin(), tensor.numbers.end(), [](double x) { return std::isnan(x); });
    if (nan != tensor.numbers.end())
      throw bad(fmt::format("/data/{}: found NaN, expected a number", nan - tensor.numbers.begin()));
  }
  return tensor;
}

}  // namespace

TensorForm tensor_form(const std::string& word) {
  return word == "json" ? TensorForm::json : word == "binary" ? TensorForm::binary : TensorForm::automatic;
}

std::map<std::string, Tensor> tensors_from(const Json& reply, const std::vector<TensorSpecification>& outputs,
                                           const std::string& source, const std::string& binary) {
  if (!reply.is_object() || !reply.contains("outputs") || !reply.at("outputs").is_array()) {
    if (reply.is_object() && reply.contains("error"))
      throw provider_error(source, "the server answers with an error: " + words_of(reply.dump()));
    throw provider_error(source, "/outputs: found none, expected a v2 inference reply");
  }
  // Binary contents follow each other in the order of the outputs, those that nobody asked for included.
  std::map<std::string, std::pair<const Json*, std::optional<std::string>>> found;
  size_t at = 0;
  for (const Json& output : reply.at("outputs")) {
    if (!output.is_object() || !output.value("name", Json()).is_string()) continue;
    const std::string name = output.at("name").get<std::string>();
    std::optional<std::string> bytes;
    if (const auto size = binary_size(output, "/outputs/" + one_line(name, 80), source)) {
      if (*size > binary.size() - at)
        throw provider_error(source, fmt::format("/outputs/{}: found {} bytes behind the JSON, expected {}",
                                                 one_line(name, 80), binary.size() - at, *size));
      bytes = binary.substr(at, *size);
      at += *size;
    }
    found[name] = {&output, std::move(bytes)};
  }
  std::map<std::string, Tensor> tensors;
  for (const TensorSpecification& wanted : outputs) {
    const auto output = found.find(wanted.name);
    if (output == found.end()) throw provider_error(source, "/outputs: found no output named \"" + wanted.name + "\"");
    tensors[wanted.name] = tensor_from(*output->second.first, wanted, source, output->second.second);
  }
  return tensors;
}

std::vector<DeclaredTensor> declared_tensors(const Json& metadata, const char* field) {
  std::vector<DeclaredTensor> tensors;
  if (!metadata.is_object() || !metadata.contains(field) || !metadata.at(field).is_array()) return tensors;
  for (const Json& entry : metadata.at(field)) {
    if (!entry.is_object() || !entry.value("name", Json()).is_string()) continue;
    DeclaredTensor tensor;
    tensor.name = entry.at("name").get<std::string>();
    const Json datatype = entry.value("datatype", Json()), shape = entry.value("shape", Json());
    if (datatype.is_string()) tensor.datatype = datatype.get<std::string>();
    for (const Json& extent : shape.is_array() ? shape : Json::array())
      tensor.shape.push_back(extent.is_number_integer() ? extent.get<long>() : -1);
    tensors.push_back(std::move(tensor));
  }
  return tensors;
}

std::vector<long> shape_for(const std::vector<long>& shape, const DeclaredTensor* declared) {
  if (declared == nullptr || declared->shape.size() != shape.size() + 1) return shape;
  std::vector<long> in_front = shape, behind = shape;
  in_front.insert(in_front.begin(), 1);
  behind.push_back(1);
  return fits(in_front, declared->shape) ? in_front : fits(behind, declared->shape) ? behind : shape;
}

InferenceClient::InferenceClient(Backend& backend, std::string name, TensorForm form)
    : backend_(backend), name_(std::move(name)), form_(form) {}

const DeclaredTensor* InferenceClient::declared(const std::vector<DeclaredTensor>& tensors,
                                                const std::string& name) const {
  const auto found =
      std::find_if(tensors.begin(), tensors.end(), [&](const DeclaredTensor& t) { return t.name == name; });
  return found == tensors.end() ? nullptr : &*found;
}

bool InferenceClient::is_binary() const {
  if (form_ != TensorForm::automatic) return form_ == TensorForm::binary;
  const auto is_half = [](const DeclaredTensor& t) { return t.datatype == "FP16" || t.datatype == "BF16"; };
  return platform_.find("OpenVINO") != std::string::npos || std::any_of(inputs_.begin(), inputs_.end(), is_half) ||
         std::any_of(outputs_.begin(), outputs_.end(), is_half);
}

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
  metadata.returned_statuses = {404, 405, 501};  // servers that have no metadata of models
  const Reply reply = backend_.exchange(metadata);
  if (reply.body.is_object() && reply.body.value("platform", Json()).is_string())
    platform_ = reply.body.at("platform").get<std::string>();
  const auto require = [&](const char* field, const std::vector<std::string>& wanted) {
    std::vector<DeclaredTensor> offered = declared_tensors(reply.body, field);
    if (wanted.size() == 1 && offered.size() == 1 && offered[0].name != wanted[0]) {
      their_names_[wanted[0]] = offered[0].name;
      offered[0].name = wanted[0];
    }
    if (offered.empty()) return offered;
    for (const std::string& name : wanted) {
      if (declared(offered, name) != nullptr) continue;
      std::vector<std::string> names;
      for (const DeclaredTensor& tensor : offered) names.push_back(tensor.name);
      throw provider_error(metadata.name,
                           fmt::format("/{}: found \"{}\", expected \"{}\" among them", field,
                                       one_line(fmt::format("{}", fmt::join(names, "\", \"")), 200), name));
    }
    return offered;
  };
  inputs_ = require("inputs", inputs);
  outputs_ = require("outputs", outputs);
}

std::map<std::string, Tensor> InferenceClient::infer(const std::string& name, const std::vector<InputTensor>& inputs,
                                                     const std::vector<TensorSpecification>& outputs) {
  Request request;
  request.name = name_ + "_" + name;
  request.method = "POST";
  request.path = "/infer";
  request.reply_limit = kReplyLimit;
  request.loose_numbers = true;
  // A record says how it was asked; those of earlier versions knew one way.
  const auto record = backend_.recorded(request.name);
  const bool earlier = record && record->manner.is_null();
  const bool binary =
      record ? record->manner.is_object() && record->manner.value("tensors", "") == "binary" : is_binary();
  if (!earlier) request.manner = {{"tensors", binary ? "binary" : "json"}};
  const auto their_name = [&](const std::string& ours) {
    const auto found = their_names_.find(ours);
    return found == their_names_.end() ? ours : found->second;
  };
  request.body["inputs"] = Json::array();
  for (const InputTensor& input : inputs) {
    const DeclaredTensor* const model = earlier ? nullptr : declared(inputs_, input.name);
    std::string datatype = input.numbers.empty() ? "BYTES" : input.whole ? "INT64" : "FP32";
    // Numbers go as the model wants them.
    if (!input.numbers.empty() && model != nullptr && element_size(model->datatype) != 0) datatype = model->datatype;
    Json tensor = {{"name", their_name(input.name)}, {"shape", shape_for(input.shape, model)}, {"datatype", datatype}};
    if (input.numbers.empty()) tensor["parameters"] = {{"content_type", input.png_files.empty() ? "str" : "base64"}};
    tensor["data"] = Json::array();
    const bool whole = datatype != "BOOL" && datatype.find("INT") != std::string::npos;
    for (const double number : input.numbers) {
      tensor["data"].push_back(whole ? Json(static_cast<std::int64_t>(number)) : Json(number));
    }
    for (const std::string& text : input.texts) tensor["data"].push_back(text);
    const std::string data = fmt::format("/inputs/{}/data", request.body["inputs"].size());
    for (const std::string& png : input.png_files) {
      request.attachments.push_back({fmt::format("{}/{}", data, tensor["data"].size()), "", png, "png"});
      tensor["data"].push_back("");
    }
    if (binary) {
      const std::string bytes = !input.numbers.empty()     ? bytes_of(input.numbers, datatype)
                                : !input.png_files.empty() ? bytes_of(input.png_files)
                                                           : bytes_of(input.texts);
      tensor["parameters"] = {{"binary_data_size", bytes.size()}};
      request.parts.push_back({data, bytes});
    }
    request.body["inputs"].push_back(tensor);
  }
  request.body["outputs"] = Json::array();
  std::vector<TensorSpecification> wanted = outputs;
  for (TensorSpecification& output : wanted) {
    output.name = their_name(output.name);
    Json asked = {{"name", output.name}};
    if (binary) asked["parameters"] = {{"binary_data", true}};
    request.body["outputs"].push_back(asked);
  }
  const Reply reply = backend_.exchange(request);
  std::map<std::string, Tensor> theirs = tensors_from(reply.body, wanted, request.name, reply.binary), ours;
  for (const TensorSpecification& output : outputs) ours[output.name] = std::move(theirs.at(their_name(output.name)));
  return ours;
}

}  // namespace physmas::remote

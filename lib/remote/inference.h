// A model behind the Open Inference Protocol v2 over REST (KServe, Triton, OpenVINO Model Server, MLServer, ...).
#ifndef PHYSMAS_REMOTE_INFERENCE_H
#define PHYSMAS_REMOTE_INFERENCE_H

#include <map>
#include <string>
#include <vector>

#include "remote/backend.h"

namespace physmas::remote {

// An output. Numbers are row-major; what is not finite, which servers write as null or NaN, is NaN here.
struct Tensor {
  std::string datatype;  // FP32, INT64, UINT8, BOOL, ...
  std::vector<long> shape;
  std::vector<double> numbers;     // [product of shape]; empty when the datatype is BYTES
  std::vector<std::string> texts;  // [product of shape] of BYTES
};

// An input: pictures, texts, or numbers; exactly one of the three is set.
struct InputTensor {
  std::string name;
  std::vector<long> shape;
  std::vector<std::string> png_files;  // BYTES; elements are the base64 text of PNG files (content_type "base64")
  std::vector<std::string> texts;      // BYTES; elements are UTF-8 (content_type "str")
  std::vector<double> numbers;         // row-major
  bool whole = false;                  // numbers are INT64 instead of FP32, where the model does not say
};

// What an output must be: a negative extent may be anything. Servers that batch put extents of 1 in front, others
// behind; they do not count.
struct TensorSpecification {
  std::string name;
  std::vector<long> shape;
  bool may_be_missing = false;  // a number that is not finite says that there is none; else it is refused
};

// A tensor as a model's metadata has it.
struct DeclaredTensor {
  std::string name, datatype;
  std::vector<long> shape;
};

// How tensors travel. Binary: behind the JSON, pictures as the bytes of their files. automatic: as JSON, except for a
// model that says FP16 or BF16, which JSON does not have, or that OpenVINO serves, which takes pictures in no other
// way.
enum class TensorForm { automatic, json, binary };
TensorForm tensor_form(const std::string& word);  // auto | json | binary

class InferenceClient {
 public:
  // backend: its endpoint is the model's address, http://host/v2/models/NAME[/versions/VERSION]; must outlive the
  // client. name: stem of its exchanges.
  InferenceClient(Backend& backend, std::string name, TensorForm form = TensorForm::automatic);

  // Asks whether the model is ready and offers these inputs and outputs by name; an Error (exit code 4) says what is
  // missing. A model that says nothing of its tensors is believed to have them. One input or one output may have any
  // name.
  void require_model(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

  // Whether tensors travel in binary, as far as that is known before the first inference.
  bool is_binary() const;

  // One inference. name: of the exchange, unique. Every specified output must come back with its shape.
  std::map<std::string, Tensor> infer(const std::string& name, const std::vector<InputTensor>& inputs,
                                      const std::vector<TensorSpecification>& outputs);

 private:
  const DeclaredTensor* declared(const std::vector<DeclaredTensor>& tensors, const std::string& name) const;

  Backend& backend_;
  std::string name_;
  TensorForm form_;
  std::string platform_;
  // What the model says of itself, under our names.
  std::vector<DeclaredTensor> inputs_, outputs_;
  std::map<std::string, std::string> their_names_;  // by ours, where they differ
};

// Of a model's metadata: its "inputs" or "outputs"; empty where it says nothing.
std::vector<DeclaredTensor> declared_tensors(const Json& metadata, const char* field);

// The shape in which a model wants an input: with the axis of 1 that servers which batch have in front or behind.
std::vector<long> shape_for(const std::vector<long>& shape, const DeclaredTensor* declared);

// Reads `outputs` of a v2 reply, flat, nested, or from `binary`, which follows the JSON; an Error (exit code 4) names
// output and field. source: for messages.
std::map<std::string, Tensor> tensors_from(const Json& reply, const std::vector<TensorSpecification>& outputs,
                                           const std::string& source, const std::string& binary = "");

}  // namespace physmas::remote

#endif

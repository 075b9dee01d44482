// A model behind the Open Inference Protocol v2 over REST (KServe, Triton, OpenVINO Model Server, MLServer, ...).
#ifndef PHYSMAS_REMOTE_INFERENCE_H
#define PHYSMAS_REMOTE_INFERENCE_H

#include <map>
#include <string>
#include <vector>

#include "remote/backend.h"

namespace physmas::remote {

// An output. Numbers are row-major; a JSON null (protocol servers write it for NaN) is NaN here.
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
  bool whole = false;                  // numbers are INT64 instead of FP32
};

// What an output must be: a negative extent may be anything.
struct TensorSpecification {
  std::string name;
  std::vector<long> shape;
};

class InferenceClient {
 public:
  // backend: its endpoint is the model's address, http://host/v2/models/NAME[/versions/VERSION]; must outlive the
  // client. name: stem of its exchanges.
  InferenceClient(Backend& backend, std::string name);

  // Asks whether the model is ready and offers these inputs and outputs by name; an Error (exit code 4) says what is
  // missing.
  void require_model(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

  // One inference. name: of the exchange, unique. Every specified output must come back with its shape.
  std::map<std::string, Tensor> infer(const std::string& name, const std::vector<InputTensor>& inputs,
                                      const std::vector<TensorSpecification>& outputs);

 private:
  std::map<std::string, Tensor> ask(Request request, const std::vector<TensorSpecification>& outputs);

  Backend& backend_;
  std::string name_;
};

// Reads `outputs` of a v2 reply, flat or nested data; an Error (exit code 4) names output and field. source: for
// messages.
std::map<std::string, Tensor> tensors_from(const Json& reply, const std::vector<TensorSpecification>& outputs,
                                           const std::string& source);

}  // namespace physmas::remote

#endif

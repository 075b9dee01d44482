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
  std::vector<double> numbers;  // [product of shape]
};

// What an output must be: a negative extent may be anything.
struct TensorSpecification {
  std::string name;
  std::vector<long> shape;
};

// An input of numbers.
struct InputTensor {
  std::string name;
  std::string datatype;  // FP32, INT64, ...
  std::vector<long> shape;
  Json data;  // flat, row-major
  Json json() const;
};

class InferenceClient {
 public:
  // backend: its endpoint is the model's address, http://host/v2/models/NAME[/versions/VERSION]; must outlive the
  // client. name: stem of its exchanges.
  InferenceClient(Backend& backend, std::string name);

  // Asks whether the model is ready and offers these inputs and outputs by name; an Error (exit code 4) says what is
  // missing.
  void require_model(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

  // One inference over a batch of images: input `input` of type BYTES and shape [N], every element the base64 text of
  // a PNG file (content_type "base64"). name: of the exchange, unique. Every specified output must come back with its
  // shape; the first extent is usually N. more: inputs of numbers beside the images.
  std::map<std::string, Tensor> infer_images(const std::string& name, const std::string& input,
                                             const std::vector<std::string>& png_files,
                                             const std::vector<TensorSpecification>& outputs,
                                             const std::vector<InputTensor>& more = {});

  // One inference over numbers; as infer_images otherwise.
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

// pm-eval clip.
#include <fmt/format.h>

#include <memory>

#include "base/error.h"
#include "base/output.h"
#include "metrics/clip.h"
#include "metrics/commands.h"
#include "records/metrics.h"
#include "remote/inference.h"
#include "splat/video.h"

namespace physmas::metrics {
namespace {

struct ClipOptions {
  std::string embeddings, video, prompt, merges, image_encoder, text_encoder, out;
  remote::RemoteOptions remote;
};

std::vector<double> encode(remote::InferenceClient& client, const std::string& name, const remote::InputTensor& input,
                           const std::string& output) {
  return client.infer(name, {input}, {{output, {1, -1}}}).at(output).numbers;
}

// exchanges: with both servers, appended.
ClipEmbeddings remote_embeddings(const ClipOptions& options, std::vector<ExchangeReference>& exchanges) {
  const std::vector<int64_t> ids = load_clip_tokenizer(options.merges).encode(options.prompt);
  const auto texts = remote::open_backend(options.text_encoder, "--text-encoder", "", options.remote);
  const auto images = remote::open_backend(options.image_encoder, "--image-encoder", "", options.remote);
  const remote::TensorForm form = remote::tensor_form(options.remote.tensors);
  remote::InferenceClient text_client(*texts, "clip_text", form), image_client(*images, "clip_image", form);
  text_client.require_model({"input_ids"}, {"text_embeds"});
  image_client.require_model({"pixel_values"}, {"image_embeds"});
  ClipEmbeddings embeddings;
  remote::InputTensor tokens{"input_ids", {1, kClipContext}, {}, {}, {ids.begin(), ids.end()}, true};
  embeddings.text = encode(text_client, "prompt", tokens, "text_embeds");
  splat::decode_video(options.video, [&](const Image& frame) {
    const auto values = clip_pixels(frame);
    const remote::InputTensor pixels{
        "pixel_values", {1, 3, kClipSize, kClipSize}, {}, {}, {values.begin(), values.end()}};
    const size_t t = embeddings.frames.size();
    embeddings.frames.push_back(encode(image_client, fmt::format("frame_{:05}", t), pixels, "image_embeds"));
    if (embeddings.frames.back().size() != embeddings.text.size())
      throw remote::provider_error("the image encoder",
                                   fmt::format("found embeddings of {} numbers, expected {} as the text encoder's",
                                               embeddings.frames.back().size(), embeddings.text.size()));
  });
  for (const remote::Backend* backend : {texts.get(), images.get()})
    exchanges.insert(exchanges.end(), backend->exchanges().begin(), backend->exchanges().end());
  return embeddings;
}

int clip(const ClipOptions& options) {
  const bool from_file = !options.embeddings.empty();
  const bool all_remote = !options.video.empty() && !options.prompt.empty() && !options.merges.empty() &&
                          !options.image_encoder.empty() && !options.text_encoder.empty();
  if (!from_file && !all_remote)
    throw Error(ExitCode::usage,
                "--embeddings: found none, expected it, or --video, --prompt, --merges, --image-encoder and "
                "--text-encoder");
  std::vector<ExchangeReference> exchanges;
  const Measurement m =
      clip_similarity(from_file ? load_clip_embeddings(options.embeddings) : remote_embeddings(options, exchanges));
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "clip"}};
  if (from_file) {
    provenance.add_input(options.embeddings);
  } else {
    provenance.options.emplace_back("prompt", options.prompt);
    provenance.add_input(options.video);
    provenance.add_input(options.merges);
  }
  save_metrics(options.out, "scene", {{"clip_sim", m.valid, m.value, m.samples, m.reason}}, provenance, exchanges);
  print("clip_sim {}\n", m.valid ? fmt::format("{:.4f} ({} frames)", m.value, m.samples) : "invalid: " + m.reason);
  return 0;
}

}  // namespace

Subcommand add_clip_command(Command app) {
  const auto options = std::make_shared<ClipOptions>();
  Command command = app.add_subcommand("clip", "CLIP similarity of a video and its complete motion prompt");
  Option file =
      command.add_option("--embeddings", options->embeddings, "text [D] and frames [T,D] from a .npz or JSON file");
  command.add_option("--video", options->video, "Video whose frames are encoded").excludes(file);
  command.add_option("--prompt", options->prompt, "The complete motion prompt").excludes(file);
  command.add_option("--merges", options->merges, "CLIP's bpe_simple_vocab_16e6.txt, unpacked").excludes(file);
  command
      .add_option("--image-encoder", options->image_encoder,
                  "Model behind Open Inference Protocol v2: pixel_values [1,3,224,224] to image_embeds [1,D]")
      .excludes(file);
  command.add_option("--text-encoder", options->text_encoder, "As above: input_ids [1,77] to text_embeds [1,D]")
      .excludes(file);
  command.add_option("--out", options->out, "Metrics to write").required();
  remote::add_remote_options(command, options->remote);
  remote::add_tensor_options(command, options->remote);
  return {command, [options](const CommonOptions&) { return clip(*options); }};
}

}  // namespace physmas::metrics

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/foreign_lines.h"
#include "base/machine_limits.h"
#include "splat/libav.h"
#include "splat/video.h"

namespace physmas::splat {
namespace {

// With two threads x264 was seen to give different bytes from run to run on a busy machine.
constexpr int kEncoderThreads = 1;
constexpr const char* kQuality = "18";  // x264's constant rate factor; visually close to lossless

int even(int size) {
  return size + size % 2;
}

}  // namespace

struct VideoWriter::State {
  std::string path;
  int width, height;
  std::optional<AtomicFile> file;
  AVFormatContext* format = nullptr;
  AVStream* stream = nullptr;
  Libav<AVCodecContext> encoder;
  Libav<AVBSFContext> filter;
  Libav<SwsContext> scaler;
  Libav<AVFrame> rgb, yuv;
  Libav<AVPacket> packet;
  int64_t frames = 0;

  ~State() {
    if (format == nullptr) return;
    if (format->pb != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }

  // Faults of the file are the user's to mend (a full disk), those of memory the machine's, all others are ours.
  int check_file(int result) const {
    if (result == AVERROR(ENOMEM)) throw out_of_memory();
    if (result < 0) throw Error(ExitCode::invalid_input, path + ": cannot be written: " + libav_text(result));
    return result;
  }
  int check(int result, const char* doing) const {
    if (result == AVERROR(ENOMEM)) throw out_of_memory();
    if (result < 0) throw internal_error(fmt::format("{}: {}: {}", path, doing, libav_text(result)));
    return result;
  }
  // x264 prints a line about memory that it did not get, and libav names no reason.
  template <typename Call>
  int call_encoder(const Call& call) const {
    ForeignLines kept;
    const int result = call();
    if (result < 0 && kept.take().find("malloc") != std::string::npos) throw out_of_memory();
    return result;
  }
  template <typename T>
  T* require(T* pointer, const char* what) const {
    if (pointer == nullptr) throw internal_error(fmt::format("{}: no {}", path, what));
    return pointer;
  }
  template <typename T>
  static T* allocated(T* pointer) {
    if (pointer == nullptr) throw out_of_memory();
    return pointer;
  }

  void open_encoder(double fps);
  void open_file();
  void encode(const AVFrame* frame);
  void mux(const AVPacket* input);
};

void VideoWriter::State::open_encoder(double fps) {
  const AVCodec* codec = require(avcodec_find_encoder_by_name("libx264"), "H.264 encoder (libx264) in libavcodec");
  encoder.reset(allocated(avcodec_alloc_context3(codec)));
  encoder->width = even(width);
  encoder->height = even(height);
  encoder->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder->framerate = av_d2q(fps, 100000);
  encoder->time_base = av_inv_q(encoder->framerate);
  encoder->thread_count = kEncoderThreads;
  encoder->color_range = AVCOL_RANGE_MPEG;
  encoder->colorspace = AVCOL_SPC_BT709;
  encoder->color_primaries = AVCOL_PRI_BT709;
  encoder->color_trc = AVCOL_TRC_BT709;
  encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_opt_set(encoder->priv_data, "preset", "medium", 0);
  av_opt_set(encoder->priv_data, "crf", kQuality, 0);
  // Without this, x264's AVX-512 routines for rate control gave different bytes from run to run, even on one thread.
  check(av_opt_set(encoder->priv_data, "x264-params", "cpu-independent=1", 0), "H.264 encoder");
  check(call_encoder([&] { return avcodec_open2(encoder.get(), codec, nullptr); }), "H.264 encoder");

  rgb.reset(allocated(av_frame_alloc()));
  yuv.reset(allocated(av_frame_alloc()));
  for (AVFrame* frame : {rgb.get(), yuv.get()}) {
    frame->format = frame == rgb.get() ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_YUV420P;
    frame->width = encoder->width;
    frame->height = encoder->height;
    check(av_frame_get_buffer(frame, 0), "frame buffer");
  }
  scaler.reset(allocated(
      sws_getContext(rgb->width, rgb->height, AV_PIX_FMT_RGB24, yuv->width, yuv->height, AV_PIX_FMT_YUV420P,
                     SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT, nullptr, nullptr, nullptr)));
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  check(sws_setColorspaceDetails(scaler.get(), bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16), "BT.709 conversion");
  packet.reset(allocated(av_packet_alloc()));
}

void VideoWriter::State::open_file() {
  file.emplace(path, ".mp4");
  // "file:" keeps libav from reading a protocol into names with a colon.
  const std::string url = "file:" + file->temporary_path();
  check(avformat_alloc_output_context2(&format, nullptr, "mp4", url.c_str()), "mp4 container");
  format->flags |= AVFMT_FLAG_BITEXACT;  // no library version in the file
  stream = allocated(avformat_new_stream(format, nullptr));

  // x264 describes itself in a user-data message (NAL unit type 6): not part of the picture, and not the same after
  // an upgrade.
  AVBSFContext* raw_filter = nullptr;
  const AVBitStreamFilter* units = require(av_bsf_get_by_name("filter_units"), "filter_units in libavcodec");
  check(av_bsf_alloc(units, &raw_filter), "bitstream filter");
  filter.reset(raw_filter);
  check(avcodec_parameters_from_context(filter->par_in, encoder.get()), "stream parameters");
  filter->time_base_in = encoder->time_base;
  check(av_opt_set(filter->priv_data, "remove_types", "6", 0), "bitstream filter");
  check(av_bsf_init(filter.get()), "bitstream filter");
  check(avcodec_parameters_copy(stream->codecpar, filter->par_out), "stream parameters");
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;

  check_file(avio_open(&format->pb, url.c_str(), AVIO_FLAG_WRITE));
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  const int result = avformat_write_header(format, &options);
  av_dict_free(&options);
  check_file(result);
}

void VideoWriter::State::encode(const AVFrame* frame) {
  check(call_encoder([&] { return avcodec_send_frame(encoder.get(), frame); }), "H.264 encoder");
  for (;;) {
    const int result = call_encoder([&] { return avcodec_receive_packet(encoder.get(), packet.get()); });
    if (result == AVERROR_EOF) {
      mux(nullptr);
      return;
    }
    if (result == AVERROR(EAGAIN)) return;
    check(result, "H.264 encoder");
    packet->duration = 1;
    mux(packet.get());
  }
}

void VideoWriter::State::mux(const AVPacket* input) {
  check(av_bsf_send_packet(filter.get(), input != nullptr ? packet.get() : nullptr), "bitstream filter");
  for (;;) {
    const int result = av_bsf_receive_packet(filter.get(), packet.get());
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
    check(result, "bitstream filter");
    packet->stream_index = stream->index;
    av_packet_rescale_ts(packet.get(), filter->time_base_out, stream->time_base);
    check_file(av_interleaved_write_frame(format, packet.get()));
    if (format->pb->error < 0) check_file(format->pb->error);
  }
}

VideoWriter::VideoWriter(const std::string& path, int width, int height, double fps) : state_(new State) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || !(fps >= 0.01 && fps <= 1000)) {
    throw internal_error(
        fmt::format("{}: a video of {} x {} pixels at {} frames per second", path, width, height, fps));
  }
  silence_libav();
  state_->path = path;
  state_->width = width;
  state_->height = height;
  state_->open_encoder(fps);
  state_->open_file();
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const Image& frame) {
  State& s = *state_;
  if (frame.channels != 3 || frame.width != s.width || frame.height != s.height) {
    throw internal_error(fmt::format("{}: frame {} is not RGB of {} x {} pixels", s.path, s.frames, s.width, s.height));
  }
  for (int y = 0; y < s.rgb->height; ++y) {
    uint8_t* row = s.rgb->data[0] + static_cast<ptrdiff_t>(y) * s.rgb->linesize[0];
    std::memcpy(row, frame.at(0, std::min(y, s.height - 1)), size_t(3) * s.width);
    if (s.rgb->width > s.width) std::memcpy(row + 3 * s.width, row + 3 * (s.width - 1), 3);
  }
  // The encoder may still hold the last picture.
  s.check(av_frame_make_writable(s.yuv.get()), "frame buffer");
  sws_scale(s.scaler.get(), s.rgb->data, s.rgb->linesize, 0, s.rgb->height, s.yuv->data, s.yuv->linesize);
  s.yuv->pts = s.frames++;
  s.encode(s.yuv.get());
}

bool VideoWriter::finish() {
  State& s = *state_;
  if (s.frames == 0) throw internal_error(s.path + ": a video without frames");
  s.encode(nullptr);
  s.check_file(av_write_trailer(s.format));
  const int error = s.format->pb->error;
  const int closed = avio_closep(&s.format->pb);
  s.check_file(error);
  s.check_file(closed);
  return s.file->commit();
}

}  // namespace physmas::splat

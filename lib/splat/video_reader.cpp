#include <fmt/format.h>

#include <algorithm>
#include <cerrno>

#include "base/error.h"
#include "base/file.h"
#include "base/machine_limits.h"
#include "splat/libav.h"
#include "splat/video.h"

namespace physmas::splat {

struct VideoReader::State {
  std::string path;
  AVFormatContext* format = nullptr;
  const AVStream* stream = nullptr;
  Libav<AVCodecContext> decoder;
  Libav<AVPacket> packet;
  Libav<AVFrame> frame;
  Libav<SwsContext> scaler;
  VideoInfo info;

  ~State() { avformat_close_input(&format); }

  int check(int result, const std::string& field, const char* expected) const {
    if (result == AVERROR(ENOMEM)) throw out_of_memory();
    if (result < 0) throw invalid_input({path, field, libav_text(result), expected});
    return result;
  }
  std::string frame_name() const { return fmt::format("frame {}", info.frames); }
  Error damaged() const { return invalid_input({path, frame_name(), "damaged data", "a decodable frame"}); }

  void open();
  void feed();
  void convert(Image* picture);
};

void VideoReader::State::open() {
  silence_libav();
  regular_file_size(path);
  // Nothing but local mp4 files: a playlist or a reference could make libav open something else.
  AVDictionary* options = nullptr;
  av_dict_set(&options, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2", 0);
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const int opened = avformat_open_input(&format, ("file:" + path).c_str(), nullptr, &options);
  av_dict_free(&options);
  check(opened, "", "an mp4 video");
  check(avformat_find_stream_info(format, nullptr), "", "an mp4 video");
  const AVCodec* codec = nullptr;
  stream =
      format->streams[check(av_find_best_stream(format, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0), "", "a video stream")];
  decoder.reset(avcodec_alloc_context3(codec));
  packet.reset(av_packet_alloc());
  frame.reset(av_frame_alloc());
  if (!decoder || !packet || !frame) throw out_of_memory();
  check(avcodec_parameters_to_context(decoder.get(), stream->codecpar), "", "a decodable video stream");
  decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  check(avcodec_open2(decoder.get(), codec, nullptr), "", "a decodable video stream");
  info.width = decoder->width;
  info.height = decoder->height;
  info.fps = av_q2d(stream->avg_frame_rate);
}

// Hands the decoder what comes next in the file, or its end.
void VideoReader::State::feed() {
  const int result = av_read_frame(format, packet.get());
  if (result == AVERROR_EOF) {
    check(avcodec_send_packet(decoder.get(), nullptr), "", "a decodable video stream");
    return;
  }
  check(result, frame_name(), "readable data");
  const bool ours = packet->stream_index == stream->index;
  const bool corrupt = (packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
  const int sent = ours && !corrupt ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
  av_packet_unref(packet.get());
  if (ours && corrupt) throw damaged();
  check(sent, frame_name(), "a decodable frame");
}

void VideoReader::State::convert(Image* picture) {
  const AVPixelFormat pixels = static_cast<AVPixelFormat>(frame->format);
  scaler.reset(sws_getCachedContext(
      scaler.release(), frame->width, frame->height, pixels, frame->width, frame->height, AV_PIX_FMT_RGB24,
      SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT, nullptr, nullptr, nullptr));
  if (!scaler) {
    throw invalid_input({path, frame_name(), "an unusual pixel format", "a picture that converts to RGB"});
  }
  const int* coefficients = sws_getCoefficients(frame->colorspace == AVCOL_SPC_BT709 ? SWS_CS_ITU709 : SWS_CS_DEFAULT);
  sws_setColorspaceDetails(scaler.get(), coefficients, frame->color_range == AVCOL_RANGE_JPEG, coefficients, 1, 0,
                           1 << 16, 1 << 16);
  // libav writes rows in whole vectors, so it gets padded ones.
  const int stride = (3 * frame->width + 63) / 64 * 64;
  std::vector<uint8_t> rows(size_t(stride) * frame->height + 64);
  uint8_t* planes[] = {rows.data(), nullptr, nullptr, nullptr};
  const int strides[] = {stride, 0, 0, 0};
  sws_scale(scaler.get(), frame->data, frame->linesize, 0, frame->height, planes, strides);
  *picture = Image(frame->width, frame->height, 3);
  for (int y = 0; y < picture->height; ++y) {
    std::copy_n(rows.data() + size_t(y) * stride, size_t(3) * picture->width, picture->at(0, y));
  }
}

VideoReader::VideoReader(const std::string& path) : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->open();
}

VideoReader::~VideoReader() = default;

const VideoInfo& VideoReader::info() const {
  return state_->info;
}

bool VideoReader::next(Image* picture) {
  State& s = *state_;
  int result = avcodec_receive_frame(s.decoder.get(), s.frame.get());
  for (; result == AVERROR(EAGAIN); result = avcodec_receive_frame(s.decoder.get(), s.frame.get())) s.feed();
  if (result == AVERROR_EOF) {
    if (s.info.frames == 0 || (s.stream->nb_frames > 0 && s.stream->nb_frames != s.info.frames)) {
      throw invalid_input({s.path, "frames", fmt::format("{} decodable", s.info.frames),
                           fmt::format("{}, as the file's index says", s.stream->nb_frames)});
    }
    return false;
  }
  s.check(result, s.frame_name(), "a decodable frame");
  if (s.frame->decode_error_flags != 0 || (s.frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) throw s.damaged();
  if (picture != nullptr) s.convert(picture);
  ++s.info.frames;
  return true;
}

VideoInfo decode_video(const std::string& path, const std::function<void(const Image& frame)>& visit) {
  VideoReader reader(path);
  Image picture;
  while (reader.next(visit ? &picture : nullptr)) {
    if (visit) visit(picture);
  }
  return reader.info();
}

}  // namespace physmas::splat

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>

#include "base/error.h"
#include "splat/libav.h"
#include "splat/video.h"

namespace physmas::splat {
namespace {

struct Input {
  AVFormatContext* format = nullptr;
  ~Input() { avformat_close_input(&format); }
};

}  // namespace

VideoInfo decode_video(const std::string& path, const std::function<void(const Image& frame)>& visit) {
  silence_libav();
  struct stat status;
  if (stat(path.c_str(), &status) != 0) throw system_error(path, "cannot be read", errno);
  const auto check = [&](int result, const std::string& field, const char* expected) {
    if (result < 0) throw invalid_input({path, field, libav_text(result), expected});
    return result;
  };
  // Nothing but local mp4 files: a playlist or a reference could make libav open something else.
  Input input;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2", 0);
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const int opened = avformat_open_input(&input.format, ("file:" + path).c_str(), nullptr, &options);
  av_dict_free(&options);
  check(opened, "", "an mp4 video");
  check(avformat_find_stream_info(input.format, nullptr), "", "an mp4 video");
  const AVCodec* codec = nullptr;
  const int index =
      check(av_find_best_stream(input.format, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0), "", "a video stream");
  const AVStream* stream = input.format->streams[index];
  Libav<AVCodecContext> decoder(avcodec_alloc_context3(codec));
  Libav<AVPacket> packet(av_packet_alloc());
  Libav<AVFrame> frame(av_frame_alloc());
  if (!decoder || !packet || !frame) throw internal_error("no memory to decode " + path);
  check(avcodec_parameters_to_context(decoder.get(), stream->codecpar), "", "a decodable video stream");
  decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  check(avcodec_open2(decoder.get(), codec, nullptr), "", "a decodable video stream");

  VideoInfo info;
  info.width = decoder->width;
  info.height = decoder->height;
  info.fps = av_q2d(stream->avg_frame_rate);
  Libav<SwsContext> scaler;
  Image picture;
  const auto receive = [&] {
    for (;;) {
      const int result = avcodec_receive_frame(decoder.get(), frame.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      const std::string field = fmt::format("frame {}", info.frames);
      check(result, field, "a decodable frame");
      if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
        throw invalid_input({path, field, "damaged data", "a decodable frame"});
      }
      ++info.frames;
      if (!visit) continue;
      const AVPixelFormat format = static_cast<AVPixelFormat>(frame->format);
      scaler.reset(sws_getCachedContext(
          scaler.release(), frame->width, frame->height, format, frame->width, frame->height, AV_PIX_FMT_RGB24,
          SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT, nullptr, nullptr, nullptr));
      if (!scaler) throw invalid_input({path, field, "an unusual pixel format", "a picture that converts to RGB"});
      const int* coefficients =
          sws_getCoefficients(frame->colorspace == AVCOL_SPC_BT709 ? SWS_CS_ITU709 : SWS_CS_DEFAULT);
      sws_setColorspaceDetails(scaler.get(), coefficients, frame->color_range == AVCOL_RANGE_JPEG, coefficients, 1, 0,
                               1 << 16, 1 << 16);
      // libav writes rows in whole vectors, so it gets padded ones.
      const int stride = (3 * frame->width + 63) / 64 * 64;
      std::vector<uint8_t> rows(size_t(stride) * frame->height + 64);
      uint8_t* planes[] = {rows.data(), nullptr, nullptr, nullptr};
      const int strides[] = {stride, 0, 0, 0};
      sws_scale(scaler.get(), frame->data, frame->linesize, 0, frame->height, planes, strides);
      picture = Image(frame->width, frame->height, 3);
      for (int y = 0; y < picture.height; ++y) {
        std::copy_n(rows.data() + size_t(y) * stride, size_t(3) * picture.width, picture.at(0, y));
      }
      visit(picture);
    }
  };
  for (;;) {
    const int result = av_read_frame(input.format, packet.get());
    if (result == AVERROR_EOF) break;
    check(result, fmt::format("frame {}", info.frames), "readable data");
    const bool ours = packet->stream_index == index;
    const bool damaged = (packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
    const int sent = ours && !damaged ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
    av_packet_unref(packet.get());
    if (ours && damaged) {
      throw invalid_input({path, fmt::format("frame {}", info.frames), "damaged data", "a decodable frame"});
    }
    check(sent, fmt::format("frame {}", info.frames), "a decodable frame");
    receive();
  }
  check(avcodec_send_packet(decoder.get(), nullptr), "", "a decodable video stream");
  receive();
  if (info.frames == 0 || (stream->nb_frames > 0 && stream->nb_frames != info.frames)) {
    throw invalid_input({path, "frames", fmt::format("{} decodable", info.frames),
                         fmt::format("{}, as the file's index says", stream->nb_frames)});
  }
  return info;
}

}  // namespace physmas::splat

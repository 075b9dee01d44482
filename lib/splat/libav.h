// Ownership of libav's objects, and its error texts.
#ifndef PHYSMAS_SPLAT_LIBAV_H
#define PHYSMAS_SPLAT_LIBAV_H

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavcodec/bsf.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

namespace physmas::splat {

struct LibavDelete {
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(AVBSFContext* p) const { av_bsf_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

template <typename T>
using Libav = std::unique_ptr<T, LibavDelete>;

inline std::string libav_text(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = "";
  av_strerror(error, text, sizeof(text));
  return text;
}

// libav reports through return values; what it prints besides would break the rule of one line per error.
inline void silence_libav() {
  av_log_set_level(AV_LOG_QUIET);
}

}  // namespace physmas::splat

#endif

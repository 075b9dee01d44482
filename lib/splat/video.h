// H.264 videos in mp4 files.
#ifndef PHYSMAS_SPLAT_VIDEO_H
#define PHYSMAS_SPLAT_VIDEO_H

#include <functional>
#include <memory>
#include <string>

#include "scene/image.h"

namespace physmas::splat {

// Writes RGB frames as H.264 (x264, constant quality, yuv420p, BT.709, index at the front for streaming). The file
// appears whole on finish() or not at all. The same frames give the same bytes whatever machine load or thread count:
// the encoder runs on one thread, and the file carries neither times nor the encoder's name.
// Odd sizes are padded to even ones by repeating the last row or column. Throws an Error (exit code 3) when the file
// cannot be written.
class VideoWriter {
 public:
  // width, height: pixels, 1..16384. fps: frames per second, 0.01..1000.
  VideoWriter(const std::string& path, int width, int height, double fps);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  // frame: 3 channels, of the size given above.
  void write(const Image& frame);

  // Returns whether the file changed. At least one frame must have been written.
  bool finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct VideoInfo {
  int width = 0, height = 0;  // pixels as stored
  long frames = 0;            // frames that decode
  double fps = 0;
};

// Reads an mp4 file frame by frame in display order. Every function throws an Error (exit code 3) naming the file when
// it is no video, or when a frame is damaged or missing.
class VideoReader {
 public:
  explicit VideoReader(const std::string& path);
  ~VideoReader();
  VideoReader(const VideoReader&) = delete;
  VideoReader& operator=(const VideoReader&) = delete;

  // Decodes the next frame, as RGB into `frame` if that is not null. Returns false after the last one.
  bool next(Image* frame);

  // `frames` counts those that next() has decoded.
  const VideoInfo& info() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Decodes every frame of an mp4 file and hands each to `visit`, if given, as RGB. Errors as VideoReader.
VideoInfo decode_video(const std::string& path, const std::function<void(const Image& frame)>& visit = {});

// Frames of the video, after decoding every one of them.
inline long count_decodable_frames(const std::string& path) {
  return decode_video(path).frames;
}

}  // namespace physmas::splat

#endif

// Files within gzip.
#ifndef PHYSMAS_SCENE_GZIP_H
#define PHYSMAS_SCENE_GZIP_H

#include <zlib.h>

#include <string>

namespace physmas {

// A gzip stream that is inflated piece by piece, each into room that the caller knows to be needed.
class GzipStream {
 public:
  // path: for messages. bytes: must outlive this object.
  GzipStream(const std::string& path, const std::string& bytes);
  ~GzipStream();
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;

  static bool is_gzip(const std::string& bytes) { return bytes.compare(0, 2, "\x1f\x8b") == 0; }

  // Up to `size` bytes; fewer only at the end of the stream, whose checksum is then verified. Errors (exit code 3):
  // damaged data, a stream without end.
  size_t read(char* out, size_t size);

 private:
  std::string path_;
  z_stream stream_ = {};
  size_t left_ = 0, total_ = 0;
  bool ended_ = false;
};

}  // namespace physmas

#endif

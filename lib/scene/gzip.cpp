#include "scene/gzip.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace physmas {

GzipStream::GzipStream(const std::string& path, const std::string& bytes) : path_(path) {
  stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  left_ = bytes.size();
  constexpr int kGzipWindow = 15 + 16;
  if (inflateInit2(&stream_, kGzipWindow) != Z_OK) throw internal_error("zlib could not be started");
}

GzipStream::~GzipStream() {
  inflateEnd(&stream_);
}

size_t GzipStream::read(char* out, size_t size) {
  size_t done = 0;
  while (done < size && !ended_) {
    constexpr size_t kPiece = size_t{1} << 30;  // zlib counts in 32 bits
    const size_t room = std::min(size - done, kPiece), input = std::min(left_, kPiece);
    stream_.next_out = reinterpret_cast<Bytef*>(out + done);
    stream_.avail_out = static_cast<uInt>(room);
    stream_.avail_in = static_cast<uInt>(input);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    left_ -= input - stream_.avail_in;
    done += room - stream_.avail_out;
    total_ += room - stream_.avail_out;
    ended_ = status == Z_STREAM_END;
    if (status == Z_OK || ended_) continue;
    const bool starved = status == Z_BUF_ERROR && left_ == 0;
    throw invalid_input({path_, fmt::format("byte {} of the inflated stream", total_),
                         starved ? "the end of the file" : "damaged gzip data", "a whole gzip stream",
                         "the file may be cut off"});
  }
  return done;
}

}  // namespace physmas

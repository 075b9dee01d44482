// Deflated bytes for files that tests write.
#ifndef PHYSMAS_TESTS_DEFLATE_BYTES_H
#define PHYSMAS_TESTS_DEFLATE_BYTES_H

#include <zlib.h>

#include <string>

namespace physmas::testing {

// zlib's window bits: a bare stream as in zip archives, or one with gzip's header.
constexpr int kRawDeflate = -MAX_WBITS, kGzip = MAX_WBITS + 16;

inline std::string deflated(const std::string& data, int window_bits) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, data.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(&out[0]);
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace physmas::testing

#endif

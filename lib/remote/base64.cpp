#include "remote/base64.h"

#include <openssl/evp.h>

namespace physmas::remote {

std::string base64_of(const std::string& bytes) {
  // EVP_EncodeBlock also writes a terminating zero, which std::string has room for.
  std::string text((bytes.size() + 2) / 3 * 4, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  return text;
}

}  // namespace physmas::remote

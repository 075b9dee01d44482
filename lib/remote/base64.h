// Base64 (RFC 4648, with padding): how binary content travels in JSON.
#ifndef PHYSMAS_REMOTE_BASE64_H
#define PHYSMAS_REMOTE_BASE64_H

#include <string>

namespace physmas::remote {

std::string base64_of(const std::string& bytes);

}  // namespace physmas::remote

#endif

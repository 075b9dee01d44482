// SHA-256 of files and texts: how artifacts name the inputs they were made from.
#ifndef PHYSMAS_BASE_HASH_H
#define PHYSMAS_BASE_HASH_H

#include <string>

namespace physmas {

// Lower-case hexadecimal SHA-256, 64 characters (FIPS 180-4).
std::string sha256_text(const std::string& bytes);

// SHA-256 of a file's bytes. Throws an Error (exit code 3) when the file cannot be read.
std::string sha256_file(const std::string& path);

}  // namespace physmas

#endif

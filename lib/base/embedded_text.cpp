#include "base/embedded_text.h"

#include "base/error.h"

namespace physmas {

std::string embedded_text(const std::string& path) {
  for (int i = 0; i < kEmbeddedTextCount; ++i) {
    if (path == kEmbeddedTexts[i].path) return kEmbeddedTexts[i].text;
  }
  throw internal_error("no embedded text " + path);
}

}  // namespace physmas

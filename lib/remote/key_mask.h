// Keeps a server's key, and what else is secret about a server, out of what is written or shown, however a reply spells
// it.
#ifndef PHYSMAS_REMOTE_KEY_MASK_H
#define PHYSMAS_REMOTE_KEY_MASK_H

#include <string>
#include <vector>

namespace physmas::remote {

class KeyMask {
 public:
  // key: visible ASCII, or empty: then nothing is masked. shown: what stands for it.
  explicit KeyMask(std::string key, std::string shown = "[key]") : key_(std::move(key)), shown_(std::move(shown)) {}
  const std::string& key() const { return key_; }

  // Whether the text holds the key in any case, as it is or spelt with JSON escapes or percent signs. Header values and
  // host names come in lower case.
  bool is_in(const std::string& text) const;

  // The text with `shown` in the key's places; no more than that where the key is spelt with escapes. To be called
  // before the text is cut or folded, so that no part of the key is left.
  std::string masked(const std::string& text) const;

 private:
  std::string key_, shown_;
};

// Several of them.
class KeyMasks {
 public:
  void add(KeyMask mask) { masks_.push_back(std::move(mask)); }
  bool is_in(const std::string& text) const;
  std::string masked(std::string text) const;

 private:
  std::vector<KeyMask> masks_;
};

}  // namespace physmas::remote

#endif

// What text may do to a terminal, an editor or a page: nothing but be read.
#ifndef PHYSMAS_BASE_PRINTABLE_H
#define PHYSMAS_BASE_PRINTABLE_H

#include <string>

namespace physmas {

// Length of the UTF-8 character that begins there; 0 where none does.
size_t character_bytes(const std::string& text, size_t at);

// The text of several lines as everything that leaves the program has it, but the bytes of files: newlines and tabs
// stay; other control characters (C0, DEL, C1), controls of the writing direction, separators of lines and paragraphs
// and bytes that are no UTF-8 become question marks. base/error.h has the same for one line.
std::string printable(const std::string& text);

// Whether the character of that length does more than be read.
bool is_control(const std::string& text, size_t at, size_t bytes);

}  // namespace physmas

#endif

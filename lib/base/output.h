// Standard output, for the person or the script that asked: everything that is printed there goes through here.
#ifndef PHYSMAS_BASE_OUTPUT_H
#define PHYSMAS_BASE_OUTPUT_H

#include <fmt/format.h>

#include <string>
#include <utility>

namespace physmas {

// Prints the text, made printable (base/printable.h), at once. An Error (exit code 3) where it cannot be written, as on
// a full disk; a reader that has seen enough (`| head`) is none.
void print_text(const std::string& text);

template <class... Arguments>
void print(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  print_text(fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace physmas

#endif

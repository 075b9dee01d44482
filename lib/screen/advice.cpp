#include "screen/advice.h"

#include <cctype>

#include "base/error.h"

namespace physmas::screen {

std::string advice_for(const std::string& gate, const ExecutionRecord& execution) {
  if (gate == "numerical" && execution.divergence) {
    std::string text = execution.divergence->advice + ".";
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text;
  }
  for (const Advice& advice : kAdvice) {
    if (gate == advice.gate) return advice.text;
  }
  throw internal_error("no advice for a gate named " + gate);
}

std::string advice_table() {
  std::string table;
  for (const Advice& advice : kAdvice) table += std::string(advice.gate) + '\t' + advice.text + '\n';
  return table;
}

}  // namespace physmas::screen

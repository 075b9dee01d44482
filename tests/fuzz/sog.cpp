// The parts of a SOG scene: what meta.json holds, then its files in the order of their names "0", "1", ..., each after
// a line "--".
#include "guard.h"
#include "scene/gaussian_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  static const std::string kLine = "\n--\n";
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> parts;
  for (size_t at = 0; at <= bytes.size();) {
    const size_t end = std::min(bytes.find(kLine, at), bytes.size());
    parts.push_back(bytes.substr(at, end - at));
    at = end + kLine.size();
  }
  const auto read = [&](const std::string& name) {
    if (name == "meta.json") return parts[0];
    const size_t number =
        name.size() == 1 && name[0] >= '0' && name[0] <= '9' ? static_cast<size_t>(name[0] - '0') : 99;
    if (number + 1 >= parts.size()) throw invalid_input({"input.sog", name, "no such entry", "it"});
    return parts[number + 1];
  };
  guard([&] {
    GaussianFile file;
    file.gaussians = read_sog("input.sog", read, size, file.notes);
    sweep_values("input.sog", "Gaussian", {}, false, file);
  });
  return 0;
}

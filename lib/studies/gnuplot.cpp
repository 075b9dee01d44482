#include "studies/gnuplot.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"

namespace physmas::studies {

bool run_gnuplot(const std::string& folder, const std::string& name, const std::string& script) {
  write_file(folder + "/" + name, script);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder.c_str()) == 0) execlp("gnuplot", "gnuplot", name.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = -1;
  if (child > 0) waitpid(child, &status, 0);
  if (child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
  const bool missing = child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 127;
  log_warning(fmt::format("no plots: gnuplot {}; later: cd {} && gnuplot {}",
                          missing ? "is not installed (make deps)" : "failed", folder, name));
  return false;
}

}  // namespace physmas::studies

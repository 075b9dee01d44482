// A run's pages on this machine, so that what is marked on the preview goes straight into the run's folder.
#ifndef PHYSMAS_REPORT_SERVE_H
#define PHYSMAS_REPORT_SERVE_H

#include <functional>
#include <string>

namespace physmas::report {

struct ServeOptions {
  std::string run;   // the run's folder, with preview.html or report.html
  int port = 0;      // 0: any that is free
  int requests = 0;  // ends after as many; 0: never
};

// What a request is answered with.
struct Reply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8", body;
};

// The answer to a request, as it came: head, empty line, body. origin: "http://127.0.0.1:PORT"; token: what the path
// begins with. Only the pages are given; only an inventory, materials and a plan that their schemas accept are written,
// as marked-inventory.json, marked-materials.json and marked-plan.json in the run's folder, and only when asked from
// the page itself.
Reply answer(const std::string& request, const std::string& run, const std::string& origin, const std::string& token);

// Listens on 127.0.0.1 alone, and says at which address, which holds a token of 128 random bits. One request at a time;
// one that is larger than 4 MiB or takes longer than 5 s is dropped. Errors (exit code 3): no pages, or no such port.
void serve(const ServeOptions& options);

}  // namespace physmas::report

#endif

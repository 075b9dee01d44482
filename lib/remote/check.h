// A conversation with a model server before anything is run: what works and what does not, in about ten lines.
#ifndef PHYSMAS_REMOTE_CHECK_H
#define PHYSMAS_REMOTE_CHECK_H

#include <string>
#include <vector>

#include "remote/backend.h"

namespace physmas::remote {

struct CheckOptions {
  std::string url;
  std::string model;                                            // of a chat server; empty: the first that it names
  std::string detector = "grounding-dino", segmenter = "sam2";  // of an inference server, unless the URL names a model
  RemoteOptions remote;
};

// Asks the server and prints a line for each thing that was tried. Returns whether a run can work with it. Errors as of
// Backend, where it does not answer at all; exit code 2 for a wrong URL.
bool check_server(const CheckOptions& options);

}  // namespace physmas::remote

#endif

// What a user adds to requests: headers, and fields of the body, each in a file.
#ifndef PHYSMAS_REMOTE_REQUEST_FILES_H
#define PHYSMAS_REMOTE_REQUEST_FILES_H

#include <string>
#include <vector>

#include "records/json_fwd.h"
#include "remote/http.h"

namespace physmas::remote {

// A line "Name: value" for each header; empty lines and those that begin with # are skipped. ${NAME} in a value is that
// variable of the environment: so a key can travel under another name than Authorization and stand in no file. Errors
// have exit code 3, name file and line, and show no value: no header, one that is the protocol's own, a variable that
// is not set. path: empty for none.
struct RequestHeaders {
  std::vector<Header> headers;
  bool holds_key = false;  // one of them took PM_API_KEY, which then is sent there only
};
RequestHeaders load_request_headers(const std::string& path);

// What may stand of a header where a server's words are shown or kept.
enum class Secrecy {
  open,    // all: Host, Accept, User-Agent, and values of less than 6 characters, of which a text may be full
  masked,  // nothing
  secret   // nothing, and a reply with it is refused: by its name or its value it may be a credential
};
Secrecy secrecy_of(const Header& header);

// A JSON object whose fields are put into every chat request (JSON Merge Patch, RFC 7396: null takes a field away). An
// Error (exit code 3) where it is none, or has a field that decides what is asked: model, messages, response_format,
// stream, n. path: empty for none; then null.
Json load_body_fields(const std::string& path);

}  // namespace physmas::remote

#endif

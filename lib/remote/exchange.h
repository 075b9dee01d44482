// One exchange with a model server: request, reply, and the record of both that audits read and replays answer from.
#ifndef PHYSMAS_REMOTE_EXCHANGE_H
#define PHYSMAS_REMOTE_EXCHANGE_H

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "records/json.h"

namespace physmas::remote {

// Binary content of a request. In records the request holds only its SHA-256, and the bytes lie beside the record.
struct Attachment {
  std::string pointer;    // JSON pointer of the string in the body that carries it
  std::string prefix;     // in front of the base64 text: "data:image/png;base64,", or nothing
  std::string bytes;      // as in the file
  std::string extension;  // of that file: "png"
};

// An input tensor whose content is sent behind the JSON (the binary tensor extension).
struct BinaryPart {
  std::string pointer;  // JSON pointer of the tensor's data, which the sent JSON does not hold
  std::string bytes;
};

struct Request {
  std::string name;    // file stem of its record, unique in a run: "material_cake_sponge_1"
  std::string method;  // GET | POST
  std::string path;    // appended to the endpoint: "/chat/completions"
  Json body;           // null: none. A null field matches whatever a replayed request had there.
  std::vector<Attachment> attachments;
  std::vector<BinaryPart> parts;         // in the order in which they are sent
  std::vector<std::string> added;        // fields of the body that are the user's (--body), also those taken away
  Json manner;                           // how a question is put, kept in the record; null where there is one way only
  std::vector<int> returned_statuses;    // besides 2xx; any other status is a failure of the provider
  bool wants_json = true;                // the reply must be JSON; readiness probes have no body
  bool loose_numbers = false;            // NaN and Infinity, which are no JSON, stand for null in the reply
  size_t reply_limit = size_t{4} << 20;  // bytes
};

struct Reply {
  int status = 0;
  Json body;           // null when the status is not 2xx, or no JSON was wanted
  std::string binary;  // tensors behind the JSON, as its "binary_data_size" say
  std::string said;    // the body as text when the status is not 2xx
};

// The body with every attachment's place holding "sha256:HEX" (`recorded`), or prefix and base64 text (`sent`).
Json recorded_body(const Request& request);
Json sent_body(const Request& request);

// The bytes of a request: JSON and, behind it, its binary parts. json_length: 0 where there are none.
struct RequestBytes {
  std::string bytes;
  size_t json_length = 0;
};
RequestBytes request_bytes(const Request& request);

// The attachment's file beside the record: SHA256.EXTENSION.
std::string attachment_file(const Attachment& attachment);

// One completed exchange, schemas/exchange.json.
struct ExchangeRecord {
  std::string name;
  std::string method, url;
  Json request_body;
  std::vector<std::string> attachments;  // files beside the record
  std::vector<std::string> headers;      // names of the user's; values are kept nowhere
  std::vector<std::string> added;        // as in Request
  Json manner;                           // as in Request
  int status = 0;
  std::string content_type;
  std::string body;    // the reply, byte for byte, as far as it is text
  std::string binary;  // what follows, in a file beside the record
  Json runtime = Json::object();
  std::string sha256() const;
};

// Writes DIR/NAME.json and the attachments as DIR/SHA256.EXTENSION.
void save_exchange(const std::string& folder, const ExchangeRecord& record, const Request& request);
// Checks both hashes: an edited record is an Error (exit code 3).
ExchangeRecord load_exchange(const std::string& path);

// The first field in which `now` differs from the recorded request, as a JSON pointer with both values; empty when
// they are equal. A null in `now` matches anything.
struct Difference {
  std::string pointer, now, recorded;
};
std::optional<Difference> first_difference(const Json& now, const Json& recorded, const std::string& pointer = "");

// Whether a request is the recorded one: as first_difference of the bodies, where fields that the user added then
// (--body) count only if some are added now.
std::optional<Difference> difference_from(const ExchangeRecord& record, const Request& request);

// Reads a reply. Error (exit code 4) naming `source` unless it is JSON as this project reads it. loose_numbers: as in
// Request.
Json parse_reply(const std::string& body, const std::string& source, bool loose_numbers = false);

// What a server says in an error's body, on one line of at most 300 bytes: the message of its JSON, else its text
// without the tags. Empty when it says nothing.
std::string words_of(const std::string& body);

// An Error with exit code 4: "SOURCE: WHAT".
Error provider_error(const std::string& source, const std::string& what);

}  // namespace physmas::remote

#endif

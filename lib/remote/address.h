// The address of a model server, and what of it could be a credential.
#ifndef PHYSMAS_REMOTE_ADDRESS_H
#define PHYSMAS_REMOTE_ADDRESS_H

#include <string>
#include <vector>

namespace physmas::remote {

// The parts of an http or https URL. `origin` is scheme://host:port.
struct Url {
  std::string scheme, host, origin;
  std::string path;   // without a trailing slash
  std::string query;  // with its question mark, or empty
  bool is_loopback() const { return host == "localhost" || host == "127.0.0.1" || host == "[::1]"; }
};

// A malformed URL, another scheme, a user name, a fragment, or a query that may hold a credential is a usage Error
// (exit code 2) that shows no more of the URL than its host.
Url parse_url(const std::string& url, const std::string& flag);

// Whether a query (without its question mark) has a parameter that looks like a credential: by its name ("api-key",
// "sig"), also with percent signs, or by a value as only keys have them. pipelines/url-credentials.sh says the same;
// tests/data/addresses.txt holds both to it.
bool may_hold_credential(const std::string& query);

// scheme://host:port of an absolute URL; empty when it has none.
std::string origin_of(const std::string& url);

// Where the server at an endpoint says whether it is ready, the likeliest first: the model's own /ready and
// /v2/health/ready for the Open Inference Protocol, /models and /health for a chat server.
std::vector<std::string> readiness_addresses(const Url& endpoint);

// The part of an endpoint's path that comes before /v2/models/NAME or before /v1: "/proxy" of "/proxy/v1".
std::string path_of_server(const std::string& path);

}  // namespace physmas::remote

#endif

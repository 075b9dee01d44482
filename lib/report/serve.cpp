#include "report/serve.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <filesystem>

#include "base/clock.h"
#include "base/error.h"
#include "base/file.h"
#include "base/output.h"
#include "base/words.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas::report {
namespace {

constexpr size_t kMostBytes = size_t{4} << 20;
constexpr int kPatience = 5;  // seconds

// What a page may send, the schema that it must fit, and the variable of make that takes the file.
struct Saved {
  const char *kind, *schema, *variable;
};
constexpr std::array<Saved, 3> kSaved = {
    {{"inventory", "inventory", "INVENTORY"}, {"materials", "material_records", "AUTHORED"}, {"plan", "plan", "PLAN"}}};

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

bool is_file(const std::string& path) {
  std::error_code failure;
  return fs::is_regular_file(path, failure);
}

// The value of a header, its name in lower case; empty where there is none.
std::string header(const std::string& head, const std::string& name) {
  size_t at = head.find("\r\n");
  while (at != std::string::npos && at + 2 < head.size()) {
    const size_t end = std::min(head.find("\r\n", at + 2), head.size());
    const std::string line = head.substr(at + 2, end - at - 2);
    const size_t colon = line.find(':');
    if (colon != std::string::npos && lower_case(line.substr(0, colon)) == name) {
      const size_t first = line.find_first_not_of(" \t", colon + 1);
      return first == std::string::npos ? "" : line.substr(first, line.find_last_not_of(" \t") - first + 1);
    }
    at = end < head.size() ? end : std::string::npos;
  }
  return "";
}

const char* status_text(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 405:
      return "Method Not Allowed";
    default:
      return "Not Found";
  }
}

std::string reply_text(const Reply& reply) {
  return fmt::format(
             "HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: "
             "no-store\r\nX-Content-Type-Options: nosniff\r\n"
             "Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\nX-Frame-Options: "
             "DENY\r\n\r\n",
             reply.status, status_text(reply.status), reply.type, reply.body.size()) +
         reply.body;
}

// The whole request, or nothing where it is too large, too slow or not one.
std::string read_request(int connection) {
  std::string request;
  size_t wanted = std::string::npos;
  const Stopwatch watch;
  while (request.size() < std::min(wanted, kMostBytes)) {
    std::array<char, 65536> part;
    const ssize_t count = recv(connection, part.data(), part.size(), 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0 || watch.seconds() > kPatience) return "";
    request.append(part.data(), static_cast<size_t>(count));
    const size_t head = request.find("\r\n\r\n");
    if (head == std::string::npos) {
      if (request.size() > 65536) return "";
      continue;
    }
    const std::string length = header(request.substr(0, head), "content-length");
    if (length.size() > 8 || length.find_first_not_of("0123456789") != std::string::npos) return "";
    wanted = head + 4 + (length.empty() ? 0 : std::stoul(length));
    if (wanted > kMostBytes) return "";
  }
  return request.substr(0, std::min(wanted, request.size()));
}

void send_all(int connection, const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const ssize_t count = send(connection, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;  // whoever asked is gone
    at += static_cast<size_t>(count);
  }
}

std::string random_token() {
  std::array<unsigned char, 16> bytes;
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) throw internal_error("no random bytes");
  std::string token;
  for (const unsigned char b : bytes) token += fmt::format("{:02x}", b);
  return token;
}

// A page that may also speak to where it came from.
std::string served_page(std::string text) {
  const std::string none = "default-src 'none';";
  const size_t at = text.find(none);
  if (at != std::string::npos) text.insert(at + none.size(), " connect-src 'self';");
  return text;
}

}  // namespace

Reply answer(const std::string& request, const std::string& run, const std::string& origin, const std::string& token) {
  const size_t head_end = request.find("\r\n\r\n"), line_end = request.find("\r\n");
  if (head_end == std::string::npos) return {400, "text/plain", "no request\n"};
  const std::string head = request.substr(0, head_end), line = request.substr(0, line_end);
  const size_t first = line.find(' '), second = line.find(' ', first + 1);
  if (first == std::string::npos || second == std::string::npos) return {400, "text/plain", "no request\n"};
  const std::string method = line.substr(0, first), path = line.substr(first + 1, second - first - 1);
  // Another name for this machine is a page of somebody else's.
  if ("http://" + header(head, "host") != origin) return {403, "text/plain", "another host\n"};
  const std::string place = "/" + token + "/";
  if (path.size() < place.size() || CRYPTO_memcmp(path.data(), place.data(), place.size()) != 0)
    return {404, "text/plain", "not found\n"};
  const std::string name = path.substr(place.size());
  if (name.empty() || name == "preview.html" || name == "report.html") {
    if (method != "GET") return {405, "text/plain", "GET only\n"};
    const std::string page = !name.empty()                             ? name
                             : is_file(join_path(run, "preview.html")) ? "preview.html"
                                                                       : "report.html";
    if (!is_file(join_path(run, page))) return {404, "text/plain", "not found\n"};
    return {200, "text/html; charset=utf-8", served_page(read_file(join_path(run, page)))};
  }
  const auto saved = std::find_if(kSaved.begin(), kSaved.end(), [&](const Saved& s) { return name == s.kind; });
  if (saved == kSaved.end()) return {404, "text/plain", "not found\n"};
  if (method != "POST") return {405, "text/plain", "POST only\n"};
  if (header(head, "origin") != origin || header(head, "content-type") != "application/json")
    return {403, "text/plain", "another origin\n"};
  const std::string file = join_path(run, fmt::format("marked-{}.json", saved->kind));
  try {
    const Json record = parse_json(request.substr(head_end + 4), file);
    validate_record(record, saved->schema, file);
    write_file(file, record_text(record));
  } catch (const Error& e) {
    return {400, "text/plain; charset=utf-8", std::string(e.what()) + "\n"};
  }
  return {200, "text/plain; charset=utf-8",
          fmt::format("Saved as {0}. Give it to make: {1}={0}\n", file, saved->variable)};
}

void serve(const ServeOptions& options) {
  if (!is_file(join_path(options.run, "preview.html")) && !is_file(join_path(options.run, "report.html")))
    throw invalid_input({options.run, "", "neither preview.html nor report.html", "a run with a page",
                         "make preview RUN=" + options.run});
  const Socket listener(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(options.port));
  socklen_t size = sizeof(address);
  if (listener.fd() < 0 || bind(listener.fd(), reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listener.fd(), 8) != 0 || getsockname(listener.fd(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw system_error(fmt::format("127.0.0.1:{}", options.port), "cannot be listened on", errno);
  const std::string origin = fmt::format("http://127.0.0.1:{}", ntohs(address.sin_port)), token = random_token();
  print("{}/{}/\n", origin, token);
  for (int served = 0; options.requests == 0 || served < options.requests;) {
    const Socket connection(accept4(listener.fd(), nullptr, nullptr, SOCK_CLOEXEC));
    if (connection.fd() < 0) continue;
    const timeval patience = {kPatience, 0};
    setsockopt(connection.fd(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    setsockopt(connection.fd(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
    const std::string request = read_request(connection.fd());
    if (request.empty()) continue;
    send_all(connection.fd(), reply_text(answer(request, options.run, origin, token)));
    ++served;
  }
}

}  // namespace physmas::report

#include "report/serve.h"

#include <doctest/doctest.h>

#include <filesystem>

#include "base/file.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using report::answer;

namespace {

const std::string kOrigin = "http://127.0.0.1:4321", kToken = "00112233445566778899aabbccddeeff";
const std::string kInventory =
    R"({"schema": "physmas/inventory/1", "objects": [{"id": "a", "name": "a"}], "rows": [{"object": "a", "part": "b", "name": "b"}]})";

std::string get(const std::string& path, const std::string& host = "127.0.0.1:4321") {
  return "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n";
}
std::string post(const std::string& body, const std::string& origin = kOrigin, const std::string& token = kToken) {
  return "POST /" + token + "/inventory HTTP/1.1\r\nHost: 127.0.0.1:4321\r\nORIGIN: " + origin +
         "\r\nContent-Type: application/json\r\n\r\n" + body;
}

}  // namespace

TEST_CASE("serve: pages are given to who knows the token, and nothing else is") {
  const TemporaryFolder folder;
  const std::string run = folder.path();
  write_file(run + "/preview.html", "<meta content=\"default-src 'none'; img-src data:\">");
  write_file(run + "/plan.json", "{}");
  const report::Reply page = answer(get("/" + kToken + "/"), run, kOrigin, kToken);
  CHECK(page.status == 200);
  CHECK(page.body == "<meta content=\"default-src 'none'; connect-src 'self'; img-src data:\">");
  for (const std::string& path : {std::string("/"), std::string("/preview.html"), "/" + std::string(32, '0') + "/",
                                  "/" + kToken, "/" + kToken + "/plan.json", "/" + kToken + "/../plan.json",
                                  "/" + kToken + "/report.html", "/" + kToken + "//etc/passwd"}) {
    CAPTURE(path);
    CHECK(answer(get(path), run, kOrigin, kToken).status == 404);
  }
  CHECK(answer(get("/" + kToken + "/", "evil.example:4321"), run, kOrigin, kToken).status == 403);
  CHECK(answer("GET\r\n\r\n", run, kOrigin, kToken).status == 400);
  CHECK(answer("POST /" + kToken + "/ HTTP/1.1\r\nHost: 127.0.0.1:4321\r\n\r\n", run, kOrigin, kToken).status == 405);
}

TEST_CASE("serve: an inventory is written when the page itself sends it and its schema accepts it") {
  const TemporaryFolder folder;
  const std::string run = folder.path(), file = run + "/marked-inventory.json";
  CHECK(answer(post(kInventory, "http://evil.example"), run, kOrigin, kToken).status == 403);
  CHECK(answer(post(kInventory, ""), run, kOrigin, kToken).status == 403);
  CHECK(answer(post(kInventory, kOrigin, std::string(32, 'f')), run, kOrigin, kToken).status == 404);
  CHECK(answer(post("{}"), run, kOrigin, kToken).status == 400);
  CHECK(answer(post("no json"), run, kOrigin, kToken).status == 400);
  CHECK_FALSE(std::filesystem::exists(file));
  CHECK(answer(post(kInventory), run, kOrigin, kToken).status == 200);
  CHECK(read_file(file).find("physmas/inventory/1") != std::string::npos);
}

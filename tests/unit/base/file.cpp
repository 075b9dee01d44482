// Atomic files, portable and contained paths, hashes, error texts.
#include "base/file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/half_files.h"
#include "base/hash.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;
namespace fs = std::filesystem;

namespace {

size_t entries_in(const std::string& folder) {
  size_t n = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++n;
  return n;
}

}  // namespace

TEST_CASE("base: write_file makes folders, and leaves an unchanged file its timestamp") {
  const TemporaryFolder folder;
  const std::string path = folder / "a/b/file.txt";
  CHECK(write_file(path, "one"));
  CHECK(read_file(path) == "one");
  const auto before = fs::last_write_time(path);
  fs::last_write_time(path, before - std::chrono::hours(1));
  CHECK_FALSE(write_file(path, "one"));
  CHECK(fs::last_write_time(path) == before - std::chrono::hours(1));
  CHECK(write_file(path, "two"));
  CHECK(fs::last_write_time(path) > before - std::chrono::hours(1));
  CHECK(entries_in(folder / "a/b") == 1);
}

TEST_CASE("base: an AtomicFile without commit leaves nothing, and keeps what was there") {
  const TemporaryFolder folder;
  write_file(folder / "file", "old");
  {
    AtomicFile out(folder / "file");
    std::ofstream(out.temporary_path()) << "half";
  }
  CHECK(read_file(folder / "file") == "old");
  CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("base: files that cannot be read or written are invalid input, named") {
  const TemporaryFolder folder;
  const auto code_of = [](auto&& action) {
    try {
      action();
    } catch (const Error& e) {
      CHECK(std::string(e.what()).find('\n') == std::string::npos);
      return e.code();
    }
    return ExitCode::done;
  };
  CHECK(code_of([&] { read_file(folder / "missing"); }) == ExitCode::invalid_input);
  CHECK(code_of([&] { read_file(folder.path()); }) == ExitCode::invalid_input);
  CHECK(code_of([&] { write_file(folder.path(), "x"); }) == ExitCode::invalid_input);
  write_file(folder / "file", "12345");
  CHECK(code_of([&] { read_file(folder / "file", 4); }) == ExitCode::invalid_input);
  CHECK(code_of([&] { write_file(folder / "file/below", "x"); }) == ExitCode::invalid_input);
  // No file can be made in /proc, not even by root.
  CHECK(code_of([&] { write_file("/proc/physmas", "x"); }) == ExitCode::invalid_input);
}

TEST_CASE("base: paths of a bundle stay inside it") {
  CHECK(resolve_inside("/b", "views/front.png", "f", "p") == "/b/views/front.png");
  CHECK(resolve_inside("/b", "views/../a.ply", "f", "p") == "/b/a.ply");
  for (const char* bad : {"", "/etc/passwd", "../a", "a/../../b", ".."}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(resolve_inside("/b", bad, "f", "p"), Error);
  }
}

TEST_CASE("base: a link inside a bundle leads out of it no more than a path does") {
  const TemporaryFolder folder;
  write_file(folder / "outside.ply", "x");
  write_file(folder / "bundle/a/inside.ply", "x");
  fs::create_symlink("inside.ply", folder / "bundle/a/near.ply");
  fs::create_symlink("../outside.ply", folder / "bundle/far.ply");
  fs::create_directory_symlink(folder.path(), folder / "bundle/up");
  const std::string bundle = folder / "bundle";
  CHECK(resolve_inside(bundle, "a/near.ply", "f", "p") == bundle + "/a/near.ply");
  CHECK(resolve_inside(bundle, "a/missing.ply", "f", "p") == bundle + "/a/missing.ply");
  for (const char* bad : {"far.ply", "up/outside.ply", "up/missing.ply"}) {
    CAPTURE(bad);
    CHECK(message_of([&] { resolve_inside(bundle, bad, "f", "p"); }).find("a link that leaves") != std::string::npos);
  }
  // The bundle's folder itself may be reached through a link.
  fs::create_directory_symlink("bundle", folder / "alias");
  CHECK_NOTHROW(resolve_inside(folder / "alias", "a/near.ply", "f", "p"));
}

TEST_CASE("base: what is read or replaced is a regular file") {
  const TemporaryFolder folder;
  const std::string pipe = folder / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const auto found_pipe = [](const std::string& text) { return text.find("pipe: found a pipe") != std::string::npos; };
  // None of these waits for somebody who writes.
  CHECK(found_pipe(message_of([&] { read_file(pipe); })));
  CHECK(found_pipe(message_of([&] { sha256_file(pipe); })));
  CHECK(found_pipe(message_of([&] { write_file(pipe, "x"); })));
  fs::create_symlink("pipe", folder / "link");
  CHECK(message_of([&] { write_file(folder / "link", "x"); }).find("found a pipe") != std::string::npos);
  CHECK(fs::is_fifo(pipe));
  CHECK(entries_in(folder.path()) == 2);
}

TEST_CASE("base: half files of dead processes are swept, those of the living and of other hosts stay") {
  const TemporaryFolder folder;
  // A process that was, and its number.
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  const std::string own = half_file_name("a.h5", ""), id = std::to_string(getpid());
  const size_t at = own.find(id);
  REQUIRE(at != std::string::npos);
  const auto of_process = [&](const std::string& other) { return std::string(own).replace(at, id.size(), other); };
  const std::string dead = of_process(std::to_string(child));
  std::string elsewhere = dead;
  elsewhere[elsewhere.size() - 5] ^= 1;  // the last digit of the host
  std::string earlier = own;             // this process's number, of one that started at another time
  earlier.replace(at + id.size() + 1, 1, "99");
  for (const std::string& name : {own, dead, dead + ".mp4", elsewhere, earlier, std::string(".a.h5.tmp")})
    std::ofstream(folder / name) << "half";
  write_file(folder / "b", "x");
  for (const std::string& name : {own, elsewhere, std::string(".a.h5.tmp")}) CHECK(fs::exists(folder / name));
  for (const std::string& name : {dead, dead + ".mp4", earlier}) CHECK_FALSE(fs::exists(folder / name));
}

TEST_CASE("base: a file may have a name as long as names can be") {
  const TemporaryFolder folder;
  const std::string path = folder / std::string(255, 'x');
  CHECK(write_file(path, "one"));
  CHECK(read_file(path) == "one");
  CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("base: provenance names inputs the same way wherever the run lies") {
  const TemporaryFolder one, two;
  for (const TemporaryFolder* folder : {&one, &two}) {
    write_file(*folder / "run/spec/a.json", "x");
    CHECK(portable_path(*folder / "run/spec/a.json", *folder / "run/candidates") == "../spec/a.json");
    CHECK(portable_path(*folder / "far.ply", *folder / "a/b/c/d") == "far.ply");
  }
}

TEST_CASE("base: SHA-256 agrees with the standard's examples") {
  CHECK(sha256_text("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_text("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const TemporaryFolder folder;
  write_file(folder / "abc", "abc");
  CHECK(sha256_file(folder / "abc") == sha256_text("abc"));
}

TEST_CASE("base: an input error names file, field, found, expected and fix on one line") {
  const Error e = invalid_input({"a.json", "/rows/0", "3\n4", "a string", "quote it"});
  CHECK(std::string(e.what()) == "a.json: /rows/0: found 3 4, expected a string; quote it");
  CHECK(e.code() == ExitCode::invalid_input);
}

TEST_CASE("base: messages are one line of UTF-8, cut between characters") {
  CHECK(one_line("a\n\t\x7f b", 10) == "a  b");
  CHECK(one_line("abc", 3) == "abc");
  CHECK(one_line("abcd", 3) == "abc...");
  CHECK(one_line("ab\xc3\xa4\xc3\xa4", 3) == "ab\xc3\xa4...");
  // Cut off, continued without a beginning, too long a form, half a surrogate pair, beyond the last character.
  CHECK(one_line("\xc3") == "?");
  CHECK(one_line("\xe2\x82|\xa4|\xc0\xaf|\xe0\x80\xaf|\xed\xa0\x80|\xf4\x90\x80\x80") == "??|?|??|???|???|????");
  // What a terminal or an editor would obey: C1, the order of writing, separators, a byte order mark.
  CHECK(one_line("a\xc2\x9b"
                 "31m|\xe2\x80\xae|\xe2\x81\xa6|\xe2\x80\xa8|\xd8\x9c|\xef\xbb\xbf|\xc2\xa0") ==
        "a?31m|?|?|?|?|?|\xc2\xa0");
  CHECK(one_line("\xe2\x82\xac\xf0\x9f\x8d\xb0") == "\xe2\x82\xac\xf0\x9f\x8d\xb0");
}

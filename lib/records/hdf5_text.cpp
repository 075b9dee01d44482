#include "records/hdf5_text.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>

#include "base/error.h"

namespace physmas {
namespace {

// What an attribute holds of such a text (HDF5 File Format Specification, "Variable-length"): its length, then the
// address of a heap in the file and the number of an object there.
constexpr size_t kReferenceSize = 16;
// Of a heap ("Global Heap"): its header, and that of each object.
constexpr size_t kHeaderSize = 16;
// Texts share heaps; a long one has a heap of its own, which is little longer.
constexpr uint64_t kMaxHeap = kMaxHdf5Text + (uint64_t{1} << 20);

uint64_t number(const char* bytes, int count) {
  uint64_t value = 0;
  for (int i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// A conversion that changes nothing, so that an attribute can be read as the bytes that the file has.
herr_t leave_bytes(hid_t, hid_t, H5T_cdata_t*, size_t, size_t, size_t, void*, void*, hid_t) {
  return 0;
}

bool read_reference(hid_t attribute, char* bytes) {
  if (H5Aget_storage_size(attribute) != kReferenceSize) return false;
  const hid_t text = H5Aget_type(attribute), opaque = H5Tcreate(H5T_OPAQUE, kReferenceSize);
  static const herr_t registered = H5Tregister(H5T_PERS_SOFT, "text reference", text, opaque, leave_bytes);
  const bool read = registered >= 0 && H5Aread(attribute, opaque, bytes) >= 0;
  H5Tclose(opaque);
  H5Tclose(text);
  return read;
}

// Of the file's first byte that belongs to HDF5; addresses count from there.
uint64_t base_address(hid_t attribute) {
  const hid_t file = H5Iget_file_id(attribute), properties = H5Fget_create_plist(file);
  hsize_t size = 0;
  H5Pget_userblock(properties, &size);
  H5Pclose(properties);
  H5Fclose(file);
  return size;
}

}  // namespace

std::string read_variable_text(hid_t attribute, const std::string& path, const std::string& where) {
  const auto damaged = [&](const std::string& found) { return invalid_input({path, where, found, "a text"}); };
  std::array<char, kReferenceSize> reference = {};
  if (!read_reference(attribute, reference.data())) throw damaged("text that cannot be read");
  const uint64_t length = number(&reference[0], 4), address = number(&reference[4], 8),
                 wanted = number(&reference[12], 4);
  if (length == 0) return "";
  if (length > kMaxHdf5Text) throw invalid_input({path, where, fmt::format("{} bytes", length), "a shorter text"});

  std::ifstream file(path, std::ios::binary);
  std::array<char, kHeaderSize> header = {};
  const uint64_t start = base_address(attribute) + address;
  if (start < address || start > INT64_MAX || !file.seekg(static_cast<std::streamoff>(start)) ||
      !file.read(header.data(), kHeaderSize) || std::string(header.data(), 5) != "GCOL\x01")
    throw damaged("text without its heap");
  const uint64_t size = number(&header[8], 8);
  if (size < kHeaderSize + length || size > kMaxHeap) throw damaged(fmt::format("a heap of {} bytes", size));
  std::string heap(size - kHeaderSize, '\0');
  if (!file.read(&heap[0], static_cast<std::streamsize>(heap.size()))) throw damaged("a heap that is cut off");
  for (uint64_t at = 0; at + kHeaderSize <= heap.size();) {
    const uint64_t index = number(&heap[at], 2), stored = number(&heap[at + 8], 8);
    at += kHeaderSize;
    if (index == 0 || stored > heap.size() - at) break;  // the free space at the end, or damage
    if (index == wanted) {
      if (stored != length) throw damaged(fmt::format("{} bytes for a text of {}", stored, length));
      return heap.substr(at, length);
    }
    at += (stored + 7) / 8 * 8;
  }
  throw damaged("a heap without the text");
}

}  // namespace physmas

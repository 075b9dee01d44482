// Zeroed, aligned memory for the solver's large arrays.
#ifndef PHYSMAS_MPM_CPU_BUFFER_H
#define PHYSMAS_MPM_CPU_BUFFER_H

#include <cstdint>
#include <cstdlib>
#include <new>
#include <utility>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace physmas::mpm {

// Zeroed memory, aligned to a cache line, or to a huge page where it is large enough for some: tens of megabytes in
// small pages are more than the processor's page tables keep at hand. Pages that are never touched cost nothing, so a
// dense table of grid blocks only uses memory where material has been.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  ~Buffer() { std::free(raw_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  // Contents are lost when the buffer grows.
  void resize(size_t count) {
    size_ = count;
    if (count <= capacity_) return;
    std::free(raw_);
    capacity_ = count + count / 8;
    constexpr size_t kHugePage = size_t{1} << 21;
    const size_t bytes = capacity_ * sizeof(T);
    const size_t alignment = bytes >= 2 * kHugePage ? kHugePage : 64;
    raw_ = std::calloc(bytes + 2 * alignment, 1);
    if (!raw_) throw std::bad_alloc();
    data_ = reinterpret_cast<T*>((reinterpret_cast<std::uintptr_t>(raw_) + alignment - 1) / alignment * alignment);
#if defined(__linux__)
    // Advice only: without it everything works with small pages.
    if (alignment == kHugePage) madvise(data_, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
  }
  T* data() {
    return data_;
  }
  const T* data() const {
    return data_;
  }
  T& operator[](size_t i) {
    return data_[i];
  }
  const T& operator[](size_t i) const {
    return data_[i];
  }
  size_t size() const {
    return size_;
  }
  void swap(Buffer& other) {
    std::swap(raw_, other.raw_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  void* raw_ = nullptr;
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

}  // namespace physmas::mpm

#endif

// An array in the memory of the device.
#ifndef PHYSMAS_MPM_CUDA_DEVICE_ARRAY_H
#define PHYSMAS_MPM_CUDA_DEVICE_ARRAY_H

#include <vector>

#include "mpm/cuda/gpu.h"

namespace physmas::mpm::PHYSMAS_GPU {

template <class T>
class DeviceArray {
 public:
  explicit DeviceArray(Queue& queue) : queue_(queue) {}
  ~DeviceArray() { Queue::release(data_); }
  DeviceArray(const DeviceArray&) = delete;
  DeviceArray& operator=(const DeviceArray&) = delete;

  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t size() const { return size_; }
  size_t bytes() const { return size_ * sizeof(T); }

  // What it held is lost, unless `keep` of its first entries are asked for.
  void resize(size_t size, size_t keep = 0) {
    if (size <= size_) return;
    T* const fresh = static_cast<T*>(Queue::allocate(size * sizeof(T)));
    if (keep > 0) queue_.copy_on(fresh, data_, keep * sizeof(T));
    queue_.wait();
    Queue::release(data_);
    data_ = fresh;
    size_ = size;
  }
  void upload(const std::vector<T>& from) {
    resize(from.size());
    if (!from.empty()) queue_.copy_in(data_, from.data(), from.size() * sizeof(T));
  }
  void zero() { queue_.zero(data_, bytes()); }

 private:
  Queue& queue_;
  T* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif

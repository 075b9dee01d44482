// The solver's laws on a GPU: compiled for it, and, where there is one, compared with plain numbers on the CPU.
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "cuda/laws.h"

namespace {

using namespace laws;

template <class T>
struct LawCase {
  Branch branch;
  MaterialParameters<T> parameters;
  Mat3<T> F;
};
template <class T>
__global__ void evaluate_all(int count, T dt, const LawCase<T>* cases, T* out) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < count) evaluate(cases[i].branch, cases[i].parameters, dt, cases[i].F, out + i * kNumbers);
}

template <class T>
std::vector<LawCase<T>> make_cases() {
  std::vector<LawCase<T>> cases;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int b = 0; b < kBranchCount; ++b) {
    const Branch branch = static_cast<Branch>(b);
    const auto p = convert_parameters<T>(derive_parameters({branch, 1e5, 0.3, 1000}, {}));
    for (int k = 0; k < 1000; ++k) {
      // Small and large strains, and some inversions.
      const double size = k % 3 == 0 ? 0.01 : k % 3 == 1 ? 0.2 : 0.7;
      LawCase<T> c{branch, p, identity<T>()};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) c.F[i][j] += T(size * uniform(random));
      }
      cases.push_back(c);
    }
  }
  return cases;
}

bool succeeded(cudaError_t error, const char* what) {
  if (error != cudaSuccess) std::fprintf(stderr, "%s: %s\n", what, cudaGetErrorString(error));
  return error == cudaSuccess;
}

template <class T>
bool check(const char* name) {
  const std::vector<LawCase<T>> cases = make_cases<T>();
  const int count = static_cast<int>(cases.size());
  const T dt = T(1e-4);
  std::vector<T> on_device(static_cast<size_t>(count) * kNumbers), here(kNumbers);
  LawCase<T>* device_cases = nullptr;
  T* device_out = nullptr;
  const size_t bytes = on_device.size() * sizeof(T);
  if (!succeeded(cudaMalloc(&device_cases, count * sizeof(LawCase<T>)), "cudaMalloc") ||
      !succeeded(cudaMalloc(&device_out, bytes), "cudaMalloc") ||
      !succeeded(cudaMemcpy(device_cases, cases.data(), count * sizeof(LawCase<T>), cudaMemcpyHostToDevice), "copy")) {
    return false;
  }
  evaluate_all<<<(count + 127) / 128, 128>>>(count, dt, device_cases, device_out);
  if (!succeeded(cudaGetLastError(), "launch") ||
      !succeeded(cudaMemcpy(on_device.data(), device_out, bytes, cudaMemcpyDeviceToHost), "copy")) {
    return false;
  }
  cudaFree(device_cases);
  cudaFree(device_out);
  double worst = 0, worst_stiffness = 0;
  for (int i = 0; i < count; ++i) {
    evaluate(cases[i].branch, cases[i].parameters, dt, cases[i].F, here.data());
    for (int k = 0; k < kNumbers; ++k) {
      const double a = here[k], b = on_device[static_cast<size_t>(i) * kNumbers + k];
      const double roundings = std::fabs(a - b) / (1 + std::fabs(a)) / kEpsilon<T>;
      double& most = k == kStiffness ? worst_stiffness : worst;
      if (!(roundings <= most)) most = roundings;  // a number that is not finite counts
    }
  }
  std::printf("%s: device and CPU agree within %.1f roundings, stiffness within %.1f\n", name, worst, worst_stiffness);
  return worst <= kRoundings && worst_stiffness <= kRoundingsOfStiffness;
}

}  // namespace

int main() {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::printf("the solver's laws compile for a GPU; none is here to run them on: skipped\n");
    return 0;
  }
  const bool good = check<float>("float");
  return check<double>("double") && good ? 0 : 1;
}

// Functions of SIMD lanes against those of the standard library.
#include "mpm/math/lanes.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace physmas::mpm;

TEST_CASE("mpm lanes: logarithm and exponential are accurate over their range") {
  using V = Lanes<float>;
  using D = Lanes<double>;
  double log_error = 0, exp_error = 0, log_error_double = 0, exp_error_double = 0;
  for (int i = 0; i < 40000; ++i) {
    const float x = std::pow(10.0f, -30.0f + 60.0f * static_cast<float>(i) / 40000.0f);
    const float near_one = 1.0f + 1e-3f * (static_cast<float>(i) / 20000.0f - 1.0f);
    for (const float a : {x, near_one}) {
      const double exact = std::log(double(a));
      log_error =
          std::max(log_error, std::fabs(double(natural_log(V(a))[0]) - exact) / std::max(std::fabs(exact), 1e-30));
      const double b = a;
      log_error_double = std::max(log_error_double, std::fabs(double(natural_log(D(b))[0]) - std::log(b)) /
                                                        std::max(std::fabs(std::log(b)), 1e-30));
    }
    const float y = -80.0f + 160.0f * static_cast<float>(i) / 40000.0f;
    exp_error = std::max(exp_error, std::fabs(double(exponential(V(y))[0]) / std::exp(double(y)) - 1));
    const double z = 8.5 * y;
    exp_error_double = std::max(exp_error_double, std::fabs(double(exponential(D(z))[0]) / std::exp(z) - 1));
  }
  // Two or three roundings of the last operations.
  CHECK(log_error < 3 * double(kEpsilon<float>));
  CHECK(exp_error < 3 * double(kEpsilon<float>));
  CHECK(log_error_double < 3 * kEpsilon<double>);
  CHECK(exp_error_double < 3 * kEpsilon<double>);
  CHECK(float(natural_log(V(1.0f))[0]) == 0.0f);
  CHECK(float(exponential(V(0.0f))[0]) == 1.0f);
}

TEST_CASE("mpm lanes: inverse cube root") {
  const auto check = [](auto zero) {
    using T = decltype(zero);
    double worst = 0;
    for (int k = -3000; k <= 9000; ++k) {
      const T x = T(std::pow(10.0, k / 1000.0));
      const double exact = 1 / std::cbrt(double(x));
      worst = std::max(worst, std::fabs(double(inverse_cube_root(Lanes<T>(x))[0]) / exact - 1));
    }
    CHECK(worst < 3 * kEpsilon<T>);
  };
  check(0.0f);
  check(0.0);
}

// What most sources include of other libraries; precompiled (see Makefile). No source includes this file itself.
#ifndef PHYSMAS_BASE_COMMON_HEADERS_H
#define PHYSMAS_BASE_COMMON_HEADERS_H

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#endif

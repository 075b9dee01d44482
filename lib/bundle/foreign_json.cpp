#include "bundle/foreign_json.h"

#include <fmt/format.h>

#include <cmath>

#include "records/json.h"

namespace physmas::bundle {
namespace {

bool finite(const Json& json) {
  return json.is_number() && std::isfinite(json.get<double>());
}

}  // namespace

ForeignObject::ForeignObject(const Json& json, std::string file, std::string pointer)
    : json_(json), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!json.is_object()) throw invalid_field(file_, pointer_.empty() ? "/" : pointer_, json, "an object");
}

Error ForeignObject::error(const std::string& key, const std::string& expected, const std::string& fix) const {
  if (!json_.contains(key)) return invalid_input({file_, where(key), "nothing", expected, fix});
  return invalid_field(file_, where(key), json_.at(key), expected, fix);
}

const Json& ForeignObject::at(const std::string& key, const char* expected) const {
  if (!has(key)) throw error(key, expected);
  return json_.at(key);
}

double ForeignObject::number(const std::string& key) const {
  const Json& value = at(key, "a number");
  if (!finite(value)) throw error(key, "a finite number");
  return value.get<double>();
}

double ForeignObject::positive(const std::string& key) const {
  const double value = number(key);
  if (!(value > 0)) throw error(key, "a number above 0");
  return value;
}

int ForeignObject::pixels(const std::string& key) const {
  const double value = number(key);
  if (!(value >= 1 && value <= 32768) || value != std::floor(value)) throw error(key, "1 to 32768 pixels");
  return static_cast<int>(value);
}

std::string ForeignObject::text(const std::string& key) const {
  const Json& value = at(key, "a text");
  if (!value.is_string() || value.get<std::string>().empty()) throw error(key, "a text that is not empty");
  return value.get<std::string>();
}

std::vector<double> ForeignObject::numbers(const std::string& key) const {
  const Json& value = at(key, "a list of numbers");
  if (finite(value)) return {value.get<double>()};
  if (!value.is_array()) throw error(key, "a list of numbers");
  std::vector<double> numbers;
  for (const Json& entry : value) {
    if (!finite(entry)) throw error(key, "a list of finite numbers");
    numbers.push_back(entry.get<double>());
  }
  return numbers;
}

Eigen::Vector3d ForeignObject::vector(const std::string& key) const {
  const std::vector<double> values = numbers(key);
  if (values.size() != 3) throw error(key, "three numbers");
  return {values[0], values[1], values[2]};
}

Eigen::MatrixXd ForeignObject::matrix(const std::string& key, int rows, int columns) const {
  const std::string expected = fmt::format("{} rows of {} finite numbers", rows, columns);
  const Json& value = at(key, "a matrix");
  if (!value.is_array() || static_cast<int>(value.size()) < rows) throw error(key, expected);
  Eigen::MatrixXd matrix(rows, columns);
  for (int r = 0; r < rows; ++r) {
    if (!value[r].is_array() || static_cast<int>(value[r].size()) != columns) throw error(key, expected);
    for (int c = 0; c < columns; ++c) {
      if (!finite(value[r][c])) throw error(key, expected);
      matrix(r, c) = value[r][c].get<double>();
    }
  }
  return matrix;
}

}  // namespace physmas::bundle

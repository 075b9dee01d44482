// Checked access to JSON that other programs wrote and that no schema of ours describes.
#ifndef PHYSMAS_BUNDLE_FOREIGN_JSON_H
#define PHYSMAS_BUNDLE_FOREIGN_JSON_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "records/json.h"

namespace physmas::bundle {

// A JSON object of a file, with its JSON pointer for messages. Every function throws an Error (exit code 3) that names
// file and field when the value is not what is asked for. The object must outlive the view.
class ForeignObject {
 public:
  // Throws when `json` is no object.
  ForeignObject(const Json& json, std::string file, std::string pointer);

  bool has(const std::string& key) const { return json_.contains(key) && !json_.at(key).is_null(); }
  double number(const std::string& key) const;  // finite
  double number(const std::string& key, double absent) const { return has(key) ? number(key) : absent; }
  double positive(const std::string& key) const;
  int pixels(const std::string& key) const;  // a size of an image, 1..32768; 800.0 is accepted
  std::string text(const std::string& key) const;
  Eigen::Vector3d vector(const std::string& key) const;
  // rows: how many at least; more are ignored (a matrix may come with or without its last row).
  Eigen::MatrixXd matrix(const std::string& key, int rows, int columns) const;
  std::vector<double> numbers(const std::string& key) const;  // a list, or one number as a list of one

  Error error(const std::string& key, const std::string& expected, const std::string& fix = "") const;
  std::string where(const std::string& key) const { return pointer_ + "/" + key; }
  const std::string& file() const { return file_; }
  const Json& json() const { return json_; }

 private:
  const Json& at(const std::string& key, const char* expected) const;

  const Json& json_;
  std::string file_, pointer_;
};

}  // namespace physmas::bundle

#endif

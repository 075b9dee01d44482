// material-field.h5 of a bundle: elastic numbers and densities that another program found at points of the scene.
#ifndef PHYSMAS_RECORDS_MATERIAL_FIELD_H
#define PHYSMAS_RECORDS_MATERIAL_FIELD_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "records/provenance.h"

namespace physmas {

// Samples in the order of the file that they came from, [n] each, n at least 1.
struct MaterialField {
  std::vector<Eigen::Vector3f> position;  // scene space, as the bundle's Gaussians
  std::vector<float> E;                   // Young's modulus [Pa], > 0
  std::vector<float> nu;                  // Poisson's ratio, 0..0.5
  std::vector<float> rho;                 // density [kg/m^3], > 0
  size_t size() const { return E.size(); }
};

// The largest field that is read.
constexpr size_t kMaxFieldSamples = 10000000;

// Why a sample's numbers are none of a material, naming the number; empty when they are.
std::string sample_fault(double E, double nu, double rho);

// Errors (exit code 3): arrays of other lengths, none or too many samples, numbers of no material.
MaterialField load_material_field(const std::string& path);
// Atomic.
void save_material_field(const std::string& path, const MaterialField& field, const Provenance& provenance);

}  // namespace physmas

#endif

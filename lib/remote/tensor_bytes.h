// Tensors as bytes: the binary tensor extension of the Open Inference Protocol. Little-endian, row-major, without
// padding; a BOOL is one byte, an element of BYTES is its length in four bytes and its content.
#ifndef PHYSMAS_REMOTE_TENSOR_BYTES_H
#define PHYSMAS_REMOTE_TENSOR_BYTES_H

#include <cstddef>
#include <string>
#include <vector>

namespace physmas::remote {

// Bytes of an element; 0 for BYTES and for a datatype that the protocol does not have.
size_t element_size(const std::string& datatype);

// datatype: with an element size.
std::string bytes_of(const std::vector<double>& numbers, const std::string& datatype);
std::string bytes_of(const std::vector<std::string>& texts);

// bytes: a whole number of elements.
std::vector<double> numbers_in(const std::string& bytes, const std::string& datatype);
// False where an element does not end within the bytes.
bool texts_in(const std::string& bytes, std::vector<std::string>& texts);

}  // namespace physmas::remote

#endif

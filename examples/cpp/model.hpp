// What a program needs around the core: the bytes of a model file, which the core does not open, and variables that must be there.
#pragma once
#include <cstddef>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "rollerrig/plant/model_file.hpp"
#include "rollerrig/plant/plant.hpp"

inline std::vector<std::byte> model_bytes(std::string const& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + " cannot be opened");
  std::vector<char> const text{std::istreambuf_iterator<char>(file), {}};
  auto const* first = reinterpret_cast<std::byte const*>(text.data());
  return {first, first + text.size()};
}

inline int index_of(rollerrig::Plant const& plant, std::string const& name) {
  int const index = plant.find(name);
  if (index < 0) throw std::runtime_error("the model has no variable " + name);
  return index;
}

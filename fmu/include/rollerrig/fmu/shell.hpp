// fmu/shell.hpp - from the resources of an FMU to the plant that runs in it.
//
//   <resources>/rig.model, token of the description, processor -> [shell] -> Plant
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "rollerrig/plant/plant.hpp"

namespace rollerrig::fmu {

/// A plant that knows the model as it came, whatever parameters it has been given since.
class RigPlant : public Plant {
 public:
  explicit RigPlant(AssembledModel assembled) : Plant{assembled}, original_{std::move(assembled)} {}
  AssembledModel const& original() const { return original_; }

 private:
  AssembledModel original_;
};

/// A plant of the same model, as it was before its first run.
inline std::unique_ptr<RigPlant> anew(RigPlant const& plant) { return std::make_unique<RigPlant>(plant.original()); }

/// Opens a plant from an FMU's resources: what the functions of FMI 2.0 and 3.0 are made over.
struct RigShell {
  using Plant = RigPlant;

  /// Throws std::exception with a sentence: no such file, not the model of that description, a processor that lacks
  /// instructions.
  static std::unique_ptr<Plant> open(std::filesystem::path const& resources, std::string_view token);
};

/// The folder that a URI names, FMI 2.0: file:///a%20b. Empty: it names none.
std::filesystem::path path_of_uri(std::string_view uri);

/// Text of a tool: UTF-8 on every system.
std::filesystem::path utf8_path(std::string_view text);

/// Instructions that this library was compiled for and this machine's processor lacks, with commas; empty: none.
std::string missing_instructions();

/// Of the library: those beyond the oldest processor of its kind, with commas.
std::string needed_instructions();

}  // namespace rollerrig::fmu

// fmu/shell.hpp - from the resources of an FMU to the plant that runs in it.
//
//   <resources>/rig.model or controller.part, token of the description, processor -> [shell] -> AnyPlant
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "rollerrig/fmu/any_plant.hpp"

namespace rollerrig::fmu {

/// Opens a plant from an FMU's resources: what the functions of FMI 2.0 and 3.0 are made over.
struct AnyShell {
  using Plant = AnyPlant;

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

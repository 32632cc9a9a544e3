// fmu/shell.hpp - from the resources of an FMU to the plant that runs in it.
//
//   <resources>/rig.model or controller.part, token of the description, processor -> [shell] -> AnyPlant
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "rollerrig/plant/variable.hpp"

namespace rollerrig::fmu {

/// Throws std::exception with a sentence: no such file, not the model of that description, a processor that lacks instructions.
std::unique_ptr<AnyPlant> open_plant(std::filesystem::path const& resources, std::string_view token);

/// The folder that a URI names, FMI 2.0: file:///a%20b. Empty: it names none.
std::filesystem::path path_of_uri(std::string_view uri);

/// Text of a tool: UTF-8 on every system.
std::filesystem::path utf8_path(std::string_view text);

/// Of the library: those beyond the oldest processor of its kind, with commas.
std::string needed_instructions();

}  // namespace rollerrig::fmu

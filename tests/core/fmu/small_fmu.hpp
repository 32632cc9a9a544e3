// tests/core/fmu/small_fmu.hpp - the resources of an FMU in a folder that goes with its scope: a braked axle.
#pragma once
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "plant/models.hpp"
#include "rollerrig/plant/model_file.hpp"

namespace rollerrig::test {

struct SmallFmu {
  std::vector<std::byte> model{write_model(braked())};
  std::string token{model_token(model)};
  std::filesystem::path folder;

  SmallFmu() {
    auto const mark = std::to_string(reinterpret_cast<std::uintptr_t>(this));
    folder = std::filesystem::temp_directory_path() / ("rollerrig fmu " + mark);
    std::filesystem::create_directories(folder);
    std::ofstream file(folder / "rig.model", std::ios::binary);
    file.write(reinterpret_cast<char const*>(model.data()), static_cast<std::streamsize>(model.size()));
  }
  ~SmallFmu() { std::filesystem::remove_all(folder); }
  SmallFmu(SmallFmu const&) = delete;
  SmallFmu& operator=(SmallFmu const&) = delete;

  /// With the blanks of its name written as a URI must.
  std::string uri() const {
    std::string text = "file://";
    std::string const path = folder.generic_string();
    if (!path.starts_with('/')) text += '/';
    for (char const c : path) text += c == ' ' ? std::string("%20") : std::string(1, c);
    return text;
  }
};

}  // namespace rollerrig::test

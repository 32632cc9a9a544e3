// How stiff must the primary suspension be across for hunting to decay?  A run for each stiffness, on all cores.
//
//   rollerrig assemble bogie_rollers_constant --set 'motion.speed=210 km/h' --out bogie.model
//   primary_stiffness bogie.model
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "model.hpp"

namespace {

constexpr std::array factors{0.5, 0.8, 1.0, 1.25, 2.0};
constexpr double end = 6.0, watched_from = 5.0, step = 2e-3;  // [s]

struct Found {
  double amplitude{};  ///< of the leading wheelset at the end [m]
  rollerrig::Status status{};
};

/// The case with the lateral stiffness of all primary springs times a factor.
Found run(rollerrig::AssembledModel const& model, double factor) {
  rollerrig::Plant plant(model);
  for (char const* element : {"primary_1_left", "primary_1_right", "primary_2_left", "primary_2_right"}) {
    int const stiffness = index_of(plant, std::string(element) + ".y_stiffness");
    plant.set_parameter(stiffness, factor * plant.get(stiffness));
  }
  int const lateral = index_of(plant, "wheelset_1.lateral");
  Found found{0.0, plant.start(end)};
  for (int i = 1; found.status == rollerrig::Status::ok && plant.time() < end; ++i) {
    found.status = plant.advance(std::min(i * step, end));
    if (plant.time() > watched_from) found.amplitude = std::max(found.amplitude, std::abs(plant.get(lateral)));
  }
  return found;
}

void study(std::string const& path) {
  auto const model = rollerrig::read_model(model_bytes(path));  // every run shares its profiles and tables
  std::array<Found, factors.size()> found;
  std::atomic<std::size_t> next{0};
  auto const work = [&] {
    for (std::size_t i; (i = next++) < factors.size();) found[i] = run(model, factors[i]);
  };
  std::vector<std::thread> workers;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) workers.emplace_back(work);
  for (auto& worker : workers) worker.join();
  for (std::size_t i = 0; i < factors.size(); ++i)
    std::printf(
        "stiffness x %.2f: %.4f mm, %s\n", factors[i], 1e3 * found[i].amplitude,
        found[i].status == rollerrig::Status::ok ? "ok" : std::string(status_sentence(found[i].status)).c_str());
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count == 2) return study(words[1]), 0;
    std::fprintf(stderr, "primary_stiffness bogie.model\n");
  } catch (std::exception const& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 2;
}

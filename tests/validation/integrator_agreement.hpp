// All integrators in the channel: the same trajectory.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "ductile/membrane/integrator.hpp"
#include "validation/channel.hpp"

namespace ductile::test {

/// One capsule of softness La from x = 0.2 until `time`: every integrator within 0.002 W of the
/// explicit one.
inline void expect_agreement(int nodes, double length, double laplace, double time) {
  const auto end = [&](std::string_view integrator) {
    Channel channel("[channel]\nnodes = " + std::to_string(nodes) +
                    "\nlength = " + std::to_string(length) + "\n[membrane]\nintegrator = \"" +
                    std::string(integrator) +
                    "\"\n[[body]]\nx = 0.2\nlaplace = " + std::to_string(laplace) + "\n");
    channel.run(time);
    return channel.sample(0);
  };
  const suspension::BodySample reference = end("explicit-euler");
  for (const std::string_view name : membrane::integrator_names()) {
    if (name == "explicit-euler") continue;
    const suspension::BodySample sample = end(name);
    std::printf("La = %g, %d nodes, t = %g: %s x = %.5f, explicit-euler %.5f\n", laplace, nodes,
                time, std::string(name).c_str(), sample.position().x(), reference.position().x());
    EXPECT_NEAR(sample.position().x(), reference.position().x(), .002) << name;
    EXPECT_NEAR(sample["strain_energy"], reference["strain_energy"],
                .02 * reference["strain_energy"])
        << name;
    EXPECT_LT(std::abs(sample["volume_error"]), .01) << name;
  }
}

}  // namespace ductile::test

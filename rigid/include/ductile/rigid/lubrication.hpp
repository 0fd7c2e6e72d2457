// Spheres that come near each other: what the lattice does not resolve of the film between them.
//
// Where a gap h is narrower than a few lattice spacings, its fluid resists a relative velocity U
// along the line of centres by more than the markers make the lattice feel. With slip at the
// markers (Surface::missed as suspension::felt_place has it) what is missing of the force depends
// on h in lattice spacings alone. It is
//
//     F = R U,  R = 6 pi eta a [g1 (a + b)/2 B(h) + g2 L(h)],  beta = b/a,
//     g1 = 2 beta^2/(1 + beta)^3,  g2 = beta (1 + 7 beta + beta^2)/(5 (1 + beta)^3),            (1)
//
// with the two singular terms of lubrication, 1/h and ln(1/h) (Jeffrey & Onishi 1984, J. Fluid
// Mech. 139, 261: X^A), less what the lattice has of them, as both and their slopes vanish at
// reaches c and d:
//
//     B = 1/h - 1/c - (2/c) ln(c/h) + (c - h)/c^2,  L = ln(d/h) - 1 + h/d.
//
// With c = 2.5 and d = 1.1 two spheres of a = 4.8 that approach meet the resistance of theory
// within 3.5% from any distance down to h = 0.1 (tests/validation/films_test.cpp).
//
// A film that is sheared resists too. By the tangential parts of U = U_a - U_b and of the angular
// velocities, n pointing from b to a,
//
//     F_a = - A U + (B_a omega_a + B_b omega_b) x n = - F_b,
//     T_a = B_a n x U - C_aa omega_a - C_ab omega_b,  T_b alike,
//     A    = 6 pi eta a 4 beta (2 + beta + 2 beta^2)/(15 (1 + beta)^3) L,
//     B_a  = 4 pi eta a^2 beta (4 + beta)/(5 (1 + beta)^2) L,  B_b alike with b and 1/beta,
//     C_aa = 8 pi eta a^3 2 beta/(5 (1 + beta)) L,  C_ab = 4 pi eta a^3 beta^2/(5 (1 + beta)) L (2)
//
// (Y^A, Y^B, Y^C of the same paper), with the velocities of the step before; torques on two that
// turn are right within 3.5% from h = 0.5 down to 0.1.
//
// R grows without bound: the force belongs to the velocity at the end of the step. That is not
// known, but foreseen: without films a sphere would go on to be accelerated as in the step before,
//
//     V* = 2 V^n - V^(n-1) - m F^n,                                                             (3)
//
// m being its velocity in one time step per force. The forces F of all films together are those
// that (1) gives for V = V* + m F, found by Gauss and Seidel's iteration. Spheres touch where the
// gap is the mean of the heights of their roughness, and push each other back to there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ductile/rigid/body.hpp"

namespace ductile::rigid {

/// R of (1) for spheres of radii a and b, at a gap above 0; lattice units. 0 from film_reach on.
double film_resistance(double a, double b, double gap, double viscosity);
/// c and d, in lattice spacings.
constexpr double film_reach = 2.5;
constexpr double shear_reach = 1.1;
/// Height of a sphere's roughness over its radius: the lower end of what Smart & Leighton 1989,
/// Phys. Fluids A 1, 52, found of small spheres.
constexpr double usual_roughness = 1e-3;

/// m of (3): of a sphere whose markers have this area together, and move a layer of fluid with them
/// within a step, and whose mass exceeds the fluid's in it by so much; and half as much again, as
/// the response differs from step to step: too much makes forces follow more slowly, too little
/// makes them overshoot.
double film_mobility(double area, double excess_mass);

/// A sphere's motion: as in State.
struct SphereMotion {
  Eigen::Vector3d position, velocity, angular_velocity;
};

/// On one sphere; torque about its centre.
struct FilmForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// The films between spheres, and their memory of the step before. All ranks of a run may keep one,
/// with the same arguments: nothing is collective.
class Lubrication {
 public:
  struct Sphere {
    double radius = 0;
    double mobility = 0;                 ///< film_mobility(); 0 of a prescribed motion
    double roughness = usual_roughness;  ///< its height over the radius
  };

  /// Spheres in a fluid that repeats itself along y and z with those periods, that along z longer
  /// than two radii; 0: it does not. Each two have one film at most with every image of each other,
  /// and none with their own. Throws std::invalid_argument for radii, mobilities, roughness, a
  /// viscosity or periods out of bounds.
  Lubrication(std::vector<Sphere> spheres, double viscosity, std::array<double, 2> periods);

  /// What the films do to the spheres in the step to come: for Body::set_film_force(). The forces
  /// add up to zero. Valid until the next call. Throws std::invalid_argument for another number of
  /// motions than spheres.
  std::span<const FilmForce> forces(std::span<const SphereMotion> motions);
  /// The step is taken for which forces() was called. One that failed has no such call, and leaves
  /// no trace.
  void accept();

  /// Writes velocities and forces of the step before, all that it remembers.
  void save(const StateWriter& write) const;
  /// Takes over what save() of one with the same arguments wrote, and goes on to the last bit as
  /// that one would have. Passes on what `read` throws, and throws std::invalid_argument for
  /// numbers that are not finite; it is then as it was.
  void load(const StateReader& read);

 private:
  struct Film {
    std::size_t a, b;
    Eigen::Vector3d normal;  // from b's centre to a's
    double gap;              // less that at which they touch
    double resistance;
    double shear;      // L
    double force = 0;  // that keeps them apart
  };

  template <class Self, class Io>
  static void transfer_parts(Self& self, const Io& io);

  void find_films(std::span<const SphereMotion> motions);
  void add_films(std::size_t a, std::size_t b, const Eigen::Vector3d& apart);
  void squeeze(std::span<const SphereMotion> motions);
  void shear(std::span<const SphereMotion> motions);
  [[nodiscard]] double force_of(const Film& film, double approach) const;

  std::vector<Sphere> spheres_;
  double viscosity_;
  std::array<double, 2> periods_;
  std::vector<Film> films_;
  std::vector<Eigen::Vector3d> free_;  // V* less what films have taken of it
  // V^(n-1) and F^n of (3), once there has been a step; and what accept() makes of them.
  double started_ = 0;
  std::vector<Eigen::Vector3d> before_;
  std::vector<Eigen::Vector3d> squeezed_;
  std::vector<Eigen::Vector3d> velocity_;
  std::vector<Eigen::Vector3d> squeezing_;
  std::vector<FilmForce> forces_;
};

}  // namespace ductile::rigid

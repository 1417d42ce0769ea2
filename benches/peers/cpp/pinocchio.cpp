// Pinocchio's forward dynamics and their derivatives, timed and checked.
//   pinocchio MODEL LOOPS SECONDS          prints peer,model,quantity,min,median in nanoseconds of CPU time
//   pinocchio MODEL --check ACCELERATIONS  compares with accelerations of another program
// Header-only use of the library: nothing of the wheel is linked, so that -march=native cannot clash with it.
#include "model.hpp"
#include <cstring>
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

using namespace pinocchio;
using Eigen::Vector3d;
using Eigen::VectorXd;
typedef Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> Rows;
typedef Eigen::Map<const Vector3d> Three;

// The fastest joint type that Pinocchio has for this hinge.
static JointModel joint(const Body &b) {
  Three axis(b.axis);
  auto along = [&](int k) { return axis[k] > 1 - 1e-12; };
  switch (b.type) {
  case 'R':
    if (along(0)) return JointModelRX();
    if (along(1)) return JointModelRY();
    if (along(2)) return JointModelRZ();
    return JointModelRevoluteUnaligned(axis);
  case 'P':
    if (along(0)) return JointModelPX();
    if (along(1)) return JointModelPY();
    if (along(2)) return JointModelPZ();
    return JointModelPrismaticUnaligned(axis);
  case 'S':
    return JointModelSpherical();
  default:
    return JointModelFreeFlyer();
  }
}

static Model build(const ModelFile &file) {
  Model model;
  model.gravity.linear() = Three(file.gravity);
  for (size_t i = 0; i < file.bodies.size(); i++) {
    const Body &b = file.bodies[i];
    const double *J = b.inertia;
    Eigen::Matrix3d inertia;
    inertia << J[0], J[3], J[4], J[3], J[1], J[5], J[4], J[5], J[2];
    SE3 placement(Eigen::Matrix3d(Rows(b.turn)), Vector3d(Three(b.place)));
    auto id = model.addJoint(b.parent + 1, joint(b), placement, "j" + std::to_string(i));
    model.appendBodyToJoint(id, Inertia(b.mass, Three(b.center), inertia), SE3::Identity());
  }
  return model;
}

// Pinocchio puts w last in quaternions, and resolves the linear velocity of a free flyer in body axes.
struct State {
  VectorXd q, v, tau;
  std::vector<Eigen::Matrix3d> turns; // of the free bodies, in order

  State(const ModelFile &file, const Model &model) : q(model.nq), v(model.nv), tau(model.nv) {
    int p = 0, r = 0;
    for (const Body &b : file.bodies) {
      for (int k = 0; k < b.positions(); k++) q[p + k] = file.position[p + k];
      for (int k = 0; k < b.velocities(); k++) v[r + k] = file.velocity[r + k], tau[r + k] = file.force[r + k];
      if (b.type == 'S' || b.type == 'F') {
        int at = p + (b.type == 'F' ? 3 : 0);
        double w = q[at];
        for (int k = 0; k < 3; k++) q[at + k] = q[at + k + 1];
        q[at + 3] = w;
        if (b.type == 'F') {
          turns.push_back(Eigen::Quaterniond(w, q[at], q[at + 1], q[at + 2]).toRotationMatrix());
          v.segment<3>(r) = (turns.back().transpose() * v.segment<3>(r)).eval();
          tau.segment<3>(r) = (turns.back().transpose() * tau.segment<3>(r)).eval();
        }
      }
      p += b.positions(), r += b.velocities();
    }
  }

  // Accelerations in the order and axes of the file, from Pinocchio's own; and back.
  std::vector<double> to_file(const ModelFile &file, VectorXd a) const { return turned(file, a, true); }
  std::vector<double> from_file(const ModelFile &file, VectorXd a) const { return turned(file, a, false); }

private:
  std::vector<double> turned(const ModelFile &file, VectorXd &a, bool out) const {
    int r = 0, free = 0;
    for (const Body &b : file.bodies) {
      if (b.type == 'F') {
        // Pinocchio's is the spatial acceleration: what turns with the body is missing.
        Vector3d carried = v.segment<3>(r + 3).cross(v.segment<3>(r));
        const Eigen::Matrix3d &turn = turns[free++];
        if (out) a.segment<3>(r) = (turn * (a.segment<3>(r) + carried)).eval();
        else a.segment<3>(r) = (turn.transpose() * a.segment<3>(r) - carried).eval();
      }
      r += b.velocities();
    }
    return std::vector<double>(a.data(), a.data() + a.size());
  }
};

static VectorXd vector(const std::vector<double> &list) { return Eigen::Map<const VectorXd>(list.data(), list.size()); }

// Prints: relative distance to aba LOCAL and WORLD; then the relative residual of inverse dynamics, ‖ID(a) − τ‖ / ‖τ₀‖,
// for the other program's accelerations, aba LOCAL and aba WORLD. τ₀ is what rest would take: ID(0) − τ.
static void check(const ModelFile &file, const Model &model, Data &data, const State &s, const char *path) {
  VectorXd theirs = vector(read_numbers(path));
  if (theirs.size() != model.nv) {
    fprintf(stderr, "%s: %d accelerations, not %d\n", path, (int)theirs.size(), model.nv);
    exit(2);
  }
  VectorXd local = aba(model, data, s.q, s.v, s.tau, Convention::LOCAL);
  VectorXd world = aba(model, data, s.q, s.v, s.tau, Convention::WORLD);
  double at_rest = (rnea(model, data, s.q, s.v, VectorXd::Zero(model.nv)) - s.tau).norm();
  auto apart = [&](const VectorXd &a) { return (theirs - vector(s.to_file(file, a))).norm() / theirs.norm(); };
  auto residual = [&](const VectorXd &a) { return (rnea(model, data, s.q, s.v, a) - s.tau).norm() / at_rest; };
  printf("%.3e %.3e %.3e %.3e %.3e\n", apart(local), apart(world), residual(vector(s.from_file(file, theirs))),
         residual(local), residual(world));
}

int main(int argc, char **argv) {
  if (argc != 4) {
    fprintf(stderr, "pinocchio MODEL LOOPS SECONDS | MODEL --check ACCELERATIONS\n");
    return 2;
  }
  ModelFile file = read_model(argv[1]);
  Model model = build(file);
  Data data(model);
  State s(file, model);
  if (!strcmp(argv[2], "--check")) {
    check(file, model, data, s, argv[3]);
    return 0;
  }
  Loops loops = {atoi(argv[2]), atof(argv[3])};
  time_it("pinocchio", file, "aba_local", loops, [&] { aba(model, data, s.q, s.v, s.tau, Convention::LOCAL); });
  time_it("pinocchio", file, "aba_world", loops, [&] { aba(model, data, s.q, s.v, s.tau, Convention::WORLD); });
  time_it("pinocchio", file, "aba_derivatives", loops, [&] { computeABADerivatives(model, data, s.q, s.v, s.tau); });
}

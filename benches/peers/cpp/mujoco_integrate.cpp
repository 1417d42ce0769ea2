// MuJoCo's integrators at fixed steps.
//   mujoco_integrate MODEL DURATION X Y Z PASSES
// prints result,integrator,setting,cpu_seconds,x,y,z,status: where the point X Y Z of the last body is in the end.
#include "mujoco.hpp"

int main(int argc, char **argv) {
  if (argc != 7) {
    fprintf(stderr, "mujoco_integrate MODEL DURATION X Y Z PASSES\n");
    return 2;
  }
  ModelFile file = read_model(argv[1]);
  const double duration = atof(argv[2]), point[3] = {atof(argv[3]), atof(argv[4]), atof(argv[5])};
  const int passes = atoi(argv[6]);
  MuJoCo mj(file);
  struct { const char *name; int id; } integrators[] = {
      {"Euler", mjINT_EULER}, {"RK4", mjINT_RK4}, {"implicit", mjINT_IMPLICIT}, {"implicitfast", mjINT_IMPLICITFAST}};
  for (auto &integrator : integrators) for (int k = 0; k <= 18; k++) {
    const int steps = std::lround(200 * std::pow(2, 0.5 * k)); // to 102400
    mj.m->opt.integrator = integrator.id;
    mj.m->opt.timestep = duration / steps;
    double best = NAN;
    for (int pass = 0; pass < passes && !(best > 1); pass++) {
      mj.start(file);
      double start = cpu_seconds();
      for (int step = 0; step < steps; step++) mj_step(mj.m, mj.d);
      best = std::fmin(best, cpu_seconds() - start);
    }
    // MuJoCo starts again from the first state where it diverges: time tells.
    bool whole = std::fabs(mj.d->time - duration) < 1e-6 * duration;
    for (int w : {mjWARN_BADQACC, mjWARN_BADQVEL, mjWARN_BADQPOS}) whole = whole && !mj.d->warning[w].number;
    mj_kinematics(mj.m, mj.d);
    int body = mj.m->nbody - 1;
    double tip[3];
    mju_mulMatVec3(tip, mj.d->xmat + 9 * body, point);
    for (int k = 0; k < 3; k++) tip[k] += mj.d->xpos[3 * body + k];
    printf("result,%s,step %.3g s,%.6g,%.17g,%.17g,%.17g,%s\n", integrator.name, duration / steps, best, tip[0], tip[1], tip[2],
           whole ? "ok" : "diverged");
    fflush(stdout);
  }
}

// A neutral model as MuJoCo's: built through mjSpec, because MJCF cannot nest a chain of 500 bodies.
#pragma once
#include "model.hpp"
#include <cstring>
#include <mujoco/mujoco.h>

struct MuJoCo {
  mjModel *m;
  mjData *d;
  std::vector<int> dof, coordinate; // of each body's hinge: MuJoCo numbers bodies its own way

  explicit MuJoCo(const ModelFile &file) {
    mjSpec *spec = mj_makeSpec();
    spec->option.disableflags |= mjDSBL_CONTACT | mjDSBL_CONSTRAINT;
    for (int k = 0; k < 3; k++) spec->option.gravity[k] = file.gravity[k];
    spec->compiler.degree = 0;
    std::vector<mjsBody *> bodies;
    for (const Body &b : file.bodies) {
      mjsBody *body = mjs_addBody(b.parent < 0 ? mjs_findBody(spec, "world") : bodies[b.parent], nullptr);
      bodies.push_back(body);
      mjs_setName(body->element, name(bodies.size() - 1).c_str());
      mju_mat2Quat(body->quat, b.turn);
      for (int k = 0; k < 3; k++) body->pos[k] = b.place[k], body->ipos[k] = b.center[k];
      for (int k = 0; k < 6; k++) body->fullinertia[k] = b.inertia[k];
      body->mass = b.mass;
      body->explicitinertial = 1;
      mjsJoint *joint = mjs_addJoint(body, nullptr);
      joint->type = b.type == 'R' ? mjJNT_HINGE : b.type == 'P' ? mjJNT_SLIDE : b.type == 'S' ? mjJNT_BALL : mjJNT_FREE;
      for (int k = 0; k < 3; k++) joint->axis[k] = b.axis[k];
      joint->stiffness[0] = b.stiffness;
      joint->damping[0] = b.damping;
    }
    m = mj_compile(spec, nullptr);
    if (!m) {
      fprintf(stderr, "%s: MuJoCo: %s\n", file.name.c_str(), mjs_getError(spec));
      exit(1);
    }
    d = mj_makeData(m);
    for (size_t i = 0; i < bodies.size(); i++) {
      int joint = m->body_jntadr[mj_name2id(m, mjOBJ_BODY, name(i).c_str())];
      dof.push_back(m->jnt_dofadr[joint]);
      coordinate.push_back(m->jnt_qposadr[joint]);
    }
  }

  // Both sides agree on the coordinates: quaternions w x y z, angular velocities in body axes, and the position of a
  // free body and its rates in the axes of the ground, on which every free body stands untilted here.
  void start(const ModelFile &file) {
    mj_resetData(m, d);
    int p = 0, r = 0;
    for (size_t i = 0; i < file.bodies.size(); i++) {
      const Body &b = file.bodies[i];
      memcpy(d->qpos + coordinate[i], &file.position[p], sizeof(double) * b.positions());
      memcpy(d->qvel + dof[i], &file.velocity[r], sizeof(double) * b.velocities());
      memcpy(d->qfrc_applied + dof[i], &file.force[r], sizeof(double) * b.velocities());
      p += b.positions(), r += b.velocities();
    }
  }

  // A number per degree of freedom, in the order of the file.
  std::vector<double> in_order(const ModelFile &file, const double *x) const {
    std::vector<double> list;
    for (size_t i = 0; i < file.bodies.size(); i++)
      list.insert(list.end(), x + dof[i], x + dof[i] + file.bodies[i].velocities());
    return list;
  }

private:
  static std::string name(size_t i) { return "b" + std::to_string(i); }
};

//! What people see when something is wrong in a scenario.

use stillpoint::scenario::{self, Override};

#[test]
fn show() {
    for text in [
        "",
        "gravty = 3\ncompletely_else=1\n[[body]]\nname='a'\nmasss=1\nhinge={type='revolut', axis=[0,1]}\n[[body]]\nmass='x'\n",
        "[[body]]\nname='a'\nmass=nan\ncenter=[0,0]\nhinge={type='revolute', axis=[0,inf,1], position=[1,2], limits=[3,1], friction=1}\n[[loop]]\ntype='x'\n[statics]\nmethod='lagrange'\npath={}\n[simulate]\nintegrator='radau5'\nstart='equilibriun'\nduration=-1\n",
        "[[body]\nname=\nmass=1\nmass=2\nx = 1 2\n",
        "[[body]]\nname='a'\nrepeat=3\nmass=[1,-2]\nhinge={type='spherical', axis=[0,1,0], position=3, stiffness=[1,2],damping=-2, at=[[1,2,3]]}\n[[force]]\ntype='spring'\nbetween=['a[0].tip', 3]\nstiffness=3\n[[force]]\ntype='load'\non={body='a[1]',at=[1,2,3],marker='x'}\n[[force]]\n",
        "a = [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
        "[[body]]\nname='a'\ndensity=7\nmass=2\nshape={box=[1,2,3], sphere=2}\nhinge={type='free', limits=[0,1]}\n[[body]]\nname='b'\ninertia=[1,2,3,4]\nshape=[{mesh='x.stl', scale=2, color='red'}]\nhinge={type='fixed', position=0}\n",
    ] {
        match scenario::parse(
            "scene.toml",
            text,
            &["simulate.duration=-1", "a.mas=2", "a.mass=-2", "b.mass=bla", "xx=2", "hinge.lock=3"]
                .map(|t| Override::parse(t).unwrap()),
        ) {
            Ok(scenario) => println!("{scenario:#?}"),
            Err(errors) => println!("{errors}\n=================="),
        }
    }
}

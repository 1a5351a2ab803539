"""Examples of each command, printed at the end of its help."""

from __future__ import annotations

EXAMPLES = {
    "": """\
examples:
  hjsolve check kepler-planar                   does it separate, and why
  hjsolve solve lagrange-top                    W, momenta, time law, orbit equations
  hjsolve coordinates henon-heiles              in which other coordinates does it separate
  hjsolve motion kepler-planar --times 0:15:31  its results, and its state at these times
  hjsolve two-point pendulum --from theta=0 --to theta=1 --time 2   the motions from one place to another
  hjsolve report kepler-planar -o kepler.html   all of that, with figures and results
  hjsolve explore kepler-planar                 a page on this machine: type, drag, read (extra explore)
  hjsolve cost kepler-planar                    measure accuracy against computing time
  hjsolve verify pendulum -S "…" --constant E   is this a complete integral of it?
  hjsolve integral kepler-planar --of p_theta   is this an integral of the motion?
  hjsolve catalog                               what is in the catalog""",
    "check": """\
examples:
  hjsolve check spherical-pendulum
  hjsolve check my-system.toml
  hjsolve check --coordinate "r: 0 < r" --coordinate "theta: angle" \\
      --kinetic "m/2*(dot(r)**2 + r**2*dot(theta)**2)" --potential "-k/r" --parameter m=1 --parameter k=1""",
    "solve": """\
examples:
  hjsolve solve kepler-spherical
  hjsolve solve --coordinate "x: line" -T "m/2*dot(x)**2" -V "m*w**2/2*x**2" --parameter m=1 --parameter w=2""",
    "verify": """\
examples:
  hjsolve verify kepler-planar -W "p*theta + integral(sqrt(2*m*(E + k/r) - p**2/r**2), r)" --constant E --constant p
  hjsolve verify --coordinate "x: line" -T "dot(x)**2/2" -V "x**2/2" --constant a \\
      -S "((x**2 + a**2)*cos(t) - 2*x*a)/(2*sin(t))"
  hjsolve verify vertical-fall -W "integral(sqrt(2*m*(a - m*g*y)), y)" --constant a --energy a
  hjsolve verify --coordinate "x: line" -T "dot(x)**2/2" -V "x**2/2" -W "integral(sqrt(2*E - x**2), x)" \\
      --constant E --q x=0.3 --velocity x=1""",
    "canonical": """\
examples:
  hjsolve canonical "Q = atan(q/p)" "P = (q**2 + p**2)/2" --domain "p: 0 < p"
  hjsolve canonical "Q = a*q" "P = b*p" --constant a --constant b
  hjsolve canonical --generating "F2 = (P + m*v)*(q - v*t)" --constant m --constant v --hamiltonian "p**2/(2*m)"
  hjsolve canonical "Q1 = q1 - q2" "Q2 = q2" "P1 = p1" "P2 = p1 + p2" --pair "q1: p1" --pair "q2: p2" """,
    "bracket": """\
examples:
  hjsolve bracket spherical-pendulum --of H --of p_phi
  hjsolve bracket --coordinate "x: line" --coordinate "y: line" -T "(dot(x)**2 + dot(y)**2)/2" \\
      --of "x*p_y - y*p_x" --of p_x""",
    "integral": """\
examples:
  hjsolve integral kepler-planar --of p_theta --of "p_r**2/2 + p_theta**2/(2*r**2) - 1/r"
  hjsolve integral --coordinate "x: line" -T "dot(x)**2/2" -V "x**2/2" --of "atan(x/p_x) - t" --of H""",
    "action": """\
examples:
  hjsolve action --coordinate "y: line" -T "dot(y)**2/2" -V "10*y" --path "y = -5*t" --between 0:1
  hjsolve action kepler-planar --path "r = 1 + t/10" --path "theta = t" --between 0:2 --digits 30""",
    "loop": """\
examples:
  hjsolve loop pendulum --q "theta=1 + sin(s)/5" --momentum "theta=cos(s)/5" --times 0:10:6""",
    "impact": """\
examples:
  hjsolve impact --coordinate "q1: line" --coordinate "q2: line" -T "2*dot(q1)**2 + dot(q2)**2/3" \\
      --q q1=0 q2=0 --velocity q1=-1 q2=0 --meets "dot(q1) - dot(q2)/2 = 0"
  hjsolve impact --coordinate "x: line" --coordinate "y: line" -T "(dot(x)**2 + dot(y)**2)/2" \\
      --q x=3 y=4 --velocity x=5 y=0 --meets "x**2 + y**2 = 25" --json""",
    "forces": """\
examples:
  hjsolve forces --coordinate "x: line" --coordinate "y: line" -T "m/2*(dot(x)**2 + dot(y)**2)" -V "m*g*y" \\
      --parameter m --parameter g --holds "y = 3*x**2"
  hjsolve forces --coordinate "x: line" --coordinate "y: line" --coordinate "theta: angle" \\
      -T "(dot(x)**2 + dot(y)**2 + dot(theta)**2)/2" --holds "dot(x)*cos(theta) + dot(y)*sin(theta) = 0" --json""",
    "contact": """\
examples:
  hjsolve contact --coordinate "x: line" --coordinate "y: line" -T "(dot(x)**2 + dot(y)**2)/2" -V y \\
      --q x=3/5 y=4/5 --velocity x=0 y=0 --holds "x**2 + y**2 >= 1"
  hjsolve contact --coordinate "x: line" --coordinate "y: line" -T "(dot(x)**2 + dot(y)**2)/2" -V y \\
      --q x=0 y=-1 --velocity x=2 y=0 --holds "x**2 + y**2 <= 1" --digits 30 --json""",
    "coordinates": """\
examples:
  hjsolve coordinates henon-heiles
  hjsolve coordinates --coordinate "x: line" --coordinate "y: line" -T "(dot(x)**2 + dot(y)**2)/2" \\
      -V "-1/sqrt(x**2 + y**2)" --place "x = (u**2 - v**2)/2" --place "y = u*v" --new "u: 0 < u" --new "v: line"
  hjsolve coordinates --coordinate "x: line" --coordinate "y: line" \\
      -T "(dot(x)**2 + dot(y)**2)/2" -V "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)"
  hjsolve coordinates --coordinate "x: line" --coordinate "y: line" \\
      -T "m*(dot(x)**2 + dot(y)**2)/2" -V "k*(x**2 + y**2 + (x - y)**2)/2" --parameter m --parameter k""",
    "motion": """\
examples:
  hjsolve motion kepler-planar                                      its numbers: kinds, turning points, periods, …
  hjsolve motion kepler-planar --times 0:15:31 > orbit.csv          31 times from 0 to 15
  hjsolve motion pendulum --q theta=3.1 --velocity theta=0 --times 0,1/2,1 --digits 30 --json
  hjsolve motion --coordinate "x: line" -T "dot(x)**2/2" -V "x**4/4" --q x=1 --velocity x=0 --times 0:10:101""",
    "two-point": """\
examples:
  hjsolve two-point kepler-planar --from r=1 theta=0 --to r=2 theta=pi/2 --time 30 --turns 0:2
  hjsolve two-point pendulum --from theta=0.3 --to theta=1 --time 2 --turns 0:1 --json
  hjsolve two-point --coordinate "x: line" -T "dot(x)**2/2" -V "x**2/2" --from x=1 --to x=0 --time 1""",
    "report": """\
examples:
  hjsolve report kepler-planar -o kepler.html
  hjsolve report kepler-planar --live -o live.html
  hjsolve report kepler-planar -o hyperbola.html --motion hyperbolic
  hjsolve report kepler-planar -o - --format md | less
  hjsolve report pendulum -o swing.md --q theta=3.1 --velocity theta=0 --parameter g=1.62
  hjsolve report --coordinate "x: line" -T "dot(x)**2/2" -V "x**4/4" --q x=1 --velocity x=0 -o quartic.html""",
    "cost": """\
examples:
  hjsolve cost kepler-planar
  hjsolve cost pendulum --motion rotation --digits 20,40,80 --seconds 120
  hjsolve cost scenes/precessing-ellipse.toml -o cost.html      with the figure
  hjsolve cost lagrange-top -o cost.svg                         the figure alone
  hjsolve cost --coordinate "x: line" -T "dot(x)**2/2" -V "x**4/4" --q x=1 --velocity x=0""",
    "sweep": """\
examples:
  hjsolve sweep orbits.toml -o orbits.parquet                      on all cores; rerun it to resume
  hjsolve sweep orbits.toml -o orbits.parquet --verify             are all parts what was written?
  hjsolve sweep orbits.toml -o orbits.parquet --scheduler tcp://10.0.0.1:8786
                                 where `dask scheduler` runs, and `dask worker tcp://10.0.0.1:8786` on many machines""",
    "explore": """\
examples:
  hjsolve explore                               begin with a double well
  hjsolve explore spherical-pendulum
  hjsolve explore scene.toml --port 8080 --no-browser""",
    "completion": """\
examples:
  hjsolve completion bash > ~/.local/share/bash-completion/completions/hjsolve
  hjsolve completion zsh > "${fpath[1]}/_hjsolve"
  hjsolve completion fish > ~/.config/fish/completions/hjsolve.fish""",
    "setup": """\
examples:
  hjsolve setup        after installing, or in a recipe that builds an image""",
    "catalog": """\
examples:
  hjsolve catalog                       list all entries
  hjsolve catalog --kind refused        those that are refused; also --separable, --book C28
  hjsolve catalog search "black hole"   entries that speak of it
  hjsolve catalog show kepler-planar    one entry: T, V, parameters, motions, effects, literature
  hjsolve catalog check my-system.toml  what is wrong with a file of your own""",
}

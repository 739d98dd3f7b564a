import re
t=open('/work/main/SAFETY.md').read()
sec=t.split('\n## Hazards\n')[1].split('\n## ')[0]
rows=[[x.strip() for x in l.strip('|').split(' | ')] for l in sec.split('\n') if l.startswith('|')][2:]
R={}
for r in rows: R[int(r[0])]=dict(zip(['hazard','cause','severity','control','remains','evidence'],r[1:]))
O={n:{} for n in R}
def o(n,**k): O[n].update(k)
o(1,control="every tick locates the sensed tip in the rest tets (`core/src/stages/presence.rs`); outside there is no force, whatever the renderer returns, and contact begins only with a fresh approach. A force there beyond five ticks is a fault (`core/src/haptic/apart.rs`)",
 rules=["Apart"],faults=["TipApart"],
 remains="located by the rest shape: contact is possible up to 1 mm above the touched triangle's rest plane; under force the guard's tip may be two radii from the sensed one",
 more="Outside the tissue the patch is shown the sensed tip. A fresh approach is also required after the probe has left elsewhere than through the touched surface, and once the surface has closed over a full sphere (`core/src/stages/output.rs`). A shown tip that is further from the sensed one than the count filter lags raises the same fault. Tissue that gravity swells by more than 1 mm is not felt, and lips and holes smaller than an element are not resolved.")
o(2,rules=["Longest","Slew"])
o(3,rules=["Gains","Slew"])
o(4,rules=[])
o(5,control="damping by the tangent stiffness (`core/src/haptic/damping.rs`), mean of a count that flips (`core/src/haptic/toggle.rs`), refusal of a narrow tip (`core/src/haptic/press.rs`), refusal or gain for a stiff contact (`core/src/haptic/ceiling.rs`), energy account, fading of a swing at rest",
 rules=["Damping","EnergyAccount","Stillness"])
o(6,rules=["Runaway"],faults=["Runaway"],
 control="commissioning (below); at most 0.5 N without it (`core/src/haptic/limits.rs`); torques by the transpose of the Jacobian (`firmware/controller/src/kinematics.rs`); checks of site and axis (`firmware/controller/src/patch/site.rs`); a fault if the probe runs away (`core/src/haptic/runaway.rs`)")
o(7,control="a released operator's switch ramps the force down and bars arming (`core/src/haptic/mode.rs`, event `OperatorLeft`); the speed fault under force, damping and the energy account bound a free handle's motion; if the host falls silent, the force ends within 120 ticks",
 rules=["Damping","EnergyAccount"],faults=["OverSpeed"],
 more="The Nucleo reads the switch at pin PF14 (PC10 on the F446 and G474), where an open pin reads as released; other boards receive its state over the link (`firmware/controller/src/link/inbox.rs`). Without a host the board arms again only when the switch is released and pressed again (`firmware/controller/src/controller.rs`).")
o(8,control="emergency stop and over-current trip in series switch the outputs off without clock or program; an open wire also does (`firmware/controller/src/force_out/bridge.rs`). A stop over the link cannot be withdrawn (`firmware/controller/src/link/inbox.rs`)",
 faults=["EmergencyStop"],
 more="On the Nucleo the stop circuit acts on the timer's break input (`TIM1_BKIN`, pin PE15, PB12 on the F446 and G474), which stays locked until the next reset. The fault is cleared only on request and never while the circuit is open. The enable line falls with every fault, panic and reset (`firmware/src/board/mod.rs`, `firmware/src/board/stack.rs`).")
o(9,control="a low magnitude pin means no force (`firmware/controller/src/force_out/bridge.rs`); every tick reads the pins back and compares force, mode and outputs (`firmware/controller/src/controller.rs`); if they differ, it switches the outputs off and raises a fault (`firmware/controller/src/haptic_loop.rs`)",
 faults=["SelfTestFailed"],
 more="The outputs are sign and magnitude. A stopped timer, a released pin with a pull-down and a hardware break also give a low magnitude. The levels of enable line and direction pins are read back, and that of a magnitude pin at 0 %.",
 evidence=R[9]['evidence']+", `a_board_that_is_not_healthy_never_arms`")
o(10,control="a fault in the same tick, latched and numbered (`core/src/haptic/limits/pose.rs`, `core/src/fault.rs`); one reading that jumps is held",faults=["PoseNotFinite","SensorFault","OutOfWorkspace","OverSpeed"])
o(11,control="two ticks are bridged with the last reading, then there is a fault; under force, more than one reading in twenty that is missing or jumps is one as well (`core/src/haptic/limits/pose.rs`)",
 faults=["PoseStale","SensorFault"],
 remains="the Nucleo's encoders are counters without a time stamp: a reading is always as new as the tick, and a dead encoder reads as a hand at rest (row 12). Jumps below the speed limit look like motion")
o(12,control="an axis whose reading stops abruptly from speed is a fault (`core/src/haptic/limits/freeze.rs`); a force above half the limit and 1 N without a count for 5 s fades within 1 s until the next contact (`core/src/haptic/stillness.rs`)",rules=["Stillness"],faults=["SensorFault"])
o(13,control="gaps in the periods' numbers show late ticks. One limits the force to half of the last one; two in a row, or five in a thousand, end it in that tick (`core/src/haptic/deadline.rs`, `firmware/controller/src/haptic_loop.rs`)",rules=["Slew"],faults=["DeadlineMissed"],
 more="The outputs are off in the tick that is late, and the fault is raised in the next one.")
o(17,control="a fault in the same tick, which persists until the supply has been good again for some time (`firmware/controller/src/haptic_loop.rs`)",faults=["SupplyLow"])
o(18,control="the account (`core/src/haptic/account.rs`), the last stage, reserves the most work of every force on its way and shortens the next; below zero there is no force, and further below than the bound a fault",rules=["EnergyAccount"],faults=["EnergyCreated"])
o(19,control="a fault if the probe, against 0.5 N or more, gains 0.5 m/s and moves 25 mm straight into the tissue, measured along the normal at its slowest moment (`core/src/haptic/runaway.rs`)",rules=["Runaway"],faults=["Runaway","OverSpeed"],
 remains="it takes 30 to 80 ticks of motion; under a firm hand that resists a wrong sign, the force limit alone bounds the force; a sudden grip of some 20 N may be taken for a runaway",
 more="A wrong sign along the surface, where the probe has friction, is bounded by mu times the push and by `Fault::OverSpeed` alone. A released handle may have passed through the tissue, two radii beyond the depth limit, where the force is zero, before the fault is certain. A probe rammed in deeper than that may be taken for a runaway.")
o(20,control="faults for nodes faster than tissue, forces that are not finite, and forces far beyond the limit for many ticks (`core/src/haptic/force_limits.rs`); the shown tip never goes deeper than the patch's depth limit (`core/src/stages/probe.rs`); an unstable step is refused",
 rules=["Plausible"],faults=["Diverged","ForceNotFinite","ForceImplausible"],
 more="A step longer than the stable one is refused when the patch is packed and, by the board's own bound, when the board accepts it (`firmware/controller/src/patch/step.rs`).")
o(21,control="CRC-32, version 4, every index and range checked before the first tick (`core/src/patch_file.rs`); the board checks cost, step and site against its own bounds. A refusal has a code, and after a damaged upload the board cannot be armed",
 faults=["SizeMismatch"],
 more="The board does not rely on the file's own statements: tick, cycles per tick (`firmware/controller/src/patch/cost.rs`), masses against stiffness (`firmware/controller/src/patch/step.rs`), site, axis and depth (`firmware/controller/src/patch/site.rs`) are checked. Every code of a refusal is explained in words.",
 evidence=R[21]['evidence']+", `state_parameters_and_model_of_different_sizes`")
o(29,control="the fast tests must notice a list of mistakes in the safety logic, each applied to a copy of the source (`tests/mutants/run`); an independent watch judges each tick from outside the loop (`host-sim/loop/src/closed_loop/watch.rs`)",
 remains="of some 3 500 mutants that cargo-mutants makes, 989 that build were tried: 925 were noticed, 13 showed gaps that tests close now, 51 are equal or differ at one value (`tests/mutants/survivors.toml`)",
 more="The list has MUTANTS mistakes; two of them change nothing observable. The watch is itself tested on 28 loops with a defect, on others that miscount energy at every delay, forget contacts, let them create energy one after another or skip the ramp-in, and its geometric part on hand-made forces (`tests/tests/haptic/no_force_without_contact/watch.rs`). Mutants of the files in `.cargo/mutants.toml` that were not tried: half of those in the haptic cycle, the guard and the controller's core, and all of those in the serving of the host, the board's checks of a patch's site and step, and the foundation. Only code that the fast tests cover is mutated.")
out=['# The hazards of SAFETY.md, from which its table is generated:',
'# `cargo test --release -p palpate-tests --test haptic -- --ignored rewrite_the_hazards`.',
'# `rules` names monitors and shapers of `core/src/haptic` by their types, `faults` the faults that',
'# are raised. `more` holds what does not fit a cell of forty words.']
bad=0
def q(s):
    return '"'+s.replace('\\','\\\\').replace('"','\\"')+'"'
def wrap(k,s):
    if len(k)+3+len(q(s))<=100: return k+' = '+q(s)
    assert '"""' not in s
    words=s.split(' '); lines=['']; 
    for w in words:
        if len(lines[-1])+len(w)+1>97: lines.append(w)
        else: lines[-1]=(lines[-1]+' '+w).lstrip(' ')
    return k+' = """\n'+' \\\n'.join(l.replace('\\','\\\\') for l in lines)+'"""'
for n in sorted(R):
    d={**R[n],'rules':[],'faults':[],'more':'',**O[n]}
    out.append('\n[[hazard]]')
    for k in ['hazard','cause','severity','control']:
        out.append(wrap(k,d[k]))
    if d['rules']: out.append('rules = ['+', '.join(q(x) for x in d['rules'])+']')
    if d['faults']: out.append('faults = ['+', '.join(q(x) for x in d['faults'])+']')
    for k in ['remains','evidence']: out.append(wrap(k,d[k]))
    if d['more']: out.append(wrap('more',d['more']))
    for k in ['hazard','cause','control','remains','evidence']:
        if len(d[k].split())>40: print(n,k,len(d[k].split())); bad+=1
open('/work/wt/sources/tests/data/hazards.toml','w').write('\n'.join(out)+'\n')

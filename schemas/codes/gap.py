"""Diagnostic codes of measurements and of simgap; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

GAP_CODES: dict[str, CodeInfo] = {
    # The folder and its files.
    "gap/missing-file": CodeInfo(
        "error",
        "A file of the measurement is absent",
        "Without measurement.yaml, trajectories or the subject's model there is nothing to compare.",
        "put the file named into the folder, or correct its name in measurement.yaml",
    ),
    "gap/path-escape": CodeInfo(
        "error",
        "A path leads out of the measurement folder",
        "A measurement is one folder that can be copied; a path outside it is unsafe and breaks on the next machine.",
        "copy the file into the folder and name it by its relative path",
    ),
    "gap/file-too-large": CodeInfo(
        "error",
        "A file is larger than the reader takes",
        "The bound keeps a damaged or hostile file from filling the memory.",
        "cut the recording into trials, one file each",
    ),
    "gap/yaml-syntax": CodeInfo(
        "error",
        "measurement.yaml is not valid YAML",
        "A parser that guesses past a syntax error reads another measurement than the one meant.",
        "correct the line named; indent with spaces and close every bracket",
    ),
    "gap/unknown-key": CodeInfo(
        "error",
        "A key has no meaning here",
        "A misspelt key would silently leave its default in force.",
        "use the key suggested, or remove it",
    ),
    "gap/missing-key": CodeInfo(
        "error",
        "A value that simulation needs is not given",
        "A made-up mass or shape would appear as a gap of the real object.",
        "add the key named with the value you believe",
    ),
    "gap/invalid-value": CodeInfo(
        "error",
        "A value has the wrong type, size or sign",
        "The value cannot mean what its key says.",
        "correct the value; units are SI and stand at the end of the key",
    ),
    "gap/inertia-below-load": CodeInfo(
        "error",
        "A joint's inertia is below that of its load",
        "A mass m whose centre is l away from the axis has at least m l^2 about it. With less, the mass centre, the "
        "mass or the inertia is wrong, and no mechanism of these numbers exists.",
        "give the total inertia about the joint's axis, load included, or correct mass_kg and com_distance_m",
    ),
    "gap/unreadable-subject": CodeInfo(
        "error",
        "The subject's model cannot be read",
        "Joint names and masses come from that file.",
        "check the file with the tool that wrote it",
    ),
    "gap/unknown-column": CodeInfo(
        "error",
        "A key of `columns` is none of our names",
        "A column that nobody looks up is data that silently plays no part.",
        "use one of the names listed; joint columns are q_, qd_, effort_ or command_ and the joint's name",
    ),
    "gap/missing-column": CodeInfo(
        "error",
        "A column that is declared or needed does not exist",
        "The kind of measurement decides which columns a comparison needs.",
        "name the file's column under `columns`, or choose the kind that fits the data",
    ),
    "gap/unreadable-table": CodeInfo(
        "error",
        "A trajectory file cannot be read as a table of numbers",
        "A file read only in part gives a motion that never happened. While other trials are sound, it is left out.",
        "export the file again: one header row, one row per sample, columns of equal length",
    ),
    "gap/unreadable-cells": CodeInfo(
        "warning",
        "Cells of a table hold no number",
        "Their rows are incomplete and are dropped where the state depends on them.",
        "look at the cell named; a logger that died in mid-line leaves such rows",
    ),
    "gap/trial-id-twice": CodeInfo(
        "error",
        "Two files have the same trial id",
        "The id is the file's name without extension; a split could mean either.",
        "rename or remove one of the two files",
    ),
    "gap/no-clock": CodeInfo(
        "error",
        "Nothing tells the time of a row",
        "Velocities and accelerations need it.",
        "declare a column t in seconds, or rate_hz",
    ),
    # Rows and stamps.
    "gap/empty-trial": CodeInfo(
        "warning",
        "A trial holds too few rows to be a motion",
        "It is left out; if none is left, there is no measurement.",
        "remove the file or record the trial again",
    ),
    "gap/non-finite-rows": CodeInfo(
        "warning",
        "Rows without a finite number were dropped",
        "A tracker that loses its target writes NaN; the row says nothing.",
        "nothing to do if they are few; the gap they leave is reported as dropped frames",
    ),
    "gap/corrupted-rows": CodeInfo(
        "warning",
        "Single rows stood far off the path and were dropped",
        "A body cannot leave its path for one frame and come back; a mirrored tag or a damaged line does that.",
        "look at the rows named; keep the raw log",
    ),
    "gap/time-not-increasing": CodeInfo(
        "warning",
        "Stamps go back or repeat; rows were sorted and repeated ones dropped",
        "Loggers that merge threads write rows out of order; a rate across such rows is meaningless.",
        "sort the log by stamp when exporting",
    ),
    "gap/clock-restarts": CodeInfo(
        "warning",
        "The stamps of a trial are no one clock",
        "Two recordings in one file, or a clock that hardly ticks, give no one motion. The trial is left out.",
        "write one file per recording",
    ),
    "gap/time-unit": CodeInfo(
        "warning",
        "Stamps are not in seconds",
        "Every velocity would be wrong by the same factor, which looks like physics. They are converted only where the "
        "rate, velocities or gravity prove the unit.",
        "write t in seconds",
    ),
    "gap/rate-mismatch": CodeInfo(
        "warning",
        "Stamps tick at another rate than declared",
        "A wrong rate scales velocities and makes gravity look wrong. The stamps are kept.",
        "correct rate_hz, or remove it: the t column rules",
    ),
    "gap/dropped-frames": CodeInfo(
        "warning",
        "Frames are missing in between",
        "A roll-out over a gap sees more error than one between neighbours; no frame is invented.",
        "nothing to do if they are few",
    ),
    "gap/stamp-jitter": CodeInfo(
        "warning",
        "Stamps jitter about a regular clock",
        "Stamps taken late by a busy computer are noise in time. They are replaced only when the motion is clearly "
        "smoother on the regular clock; otherwise sampling itself was irregular and the stamps stand.",
        "stamp at the sensor",
    ),
    # Orientations and angles.
    "gap/quaternion-not-unit": CodeInfo(
        "warning",
        "Quaternions do not have length 1",
        "Small differences are rounding and are scaled away; large ones mean other columns or lost tracking.",
        "check the four columns and their order",
    ),
    "gap/quaternion-sign": CodeInfo(
        "info",
        "Quaternions change sign between rows",
        "q and -q are the same orientation, but interpolation and differences need one sign. It was unified.",
        "nothing to do",
    ),
    "gap/quaternion-order": CodeInfo(
        "warning",
        "Quaternions are in the other order than declared",
        "As declared, the orientation does not turn with the recorded angular velocity; read the other way it does.",
        "declare q_xyzw instead of q_wxyz (or the reverse)",
    ),
    "gap/angle-wrapped": CodeInfo(
        "info",
        "A joint angle jumps by a whole turn",
        "Encoders and atan2 wrap; a difference across the jump is a false velocity. The angle was made continuous.",
        "nothing to do",
    ),
    # Units, frames, velocities.
    "gap/degrees": CodeInfo(
        "warning",
        "Angles or angular velocities are in degrees",
        "Jumps by 360, or a velocity 57.3 times the slope of its angle, prove it. They were converted.",
        "write radians",
    ),
    "gap/degrees-suspected": CodeInfo(
        "warning",
        "Angles span more than a hinge does",
        "A wheel may go round many times, a hinge within limits may not. Nothing was changed.",
        "convert to radians if the column is in degrees",
    ),
    "gap/millimetres": CodeInfo(
        "warning",
        "Positions or velocities are in millimetres",
        "A fall 1000 times too fast, or a velocity 1000 times the position's slope, proves it. They were converted.",
        "write metres",
    ),
    "gap/millimetres-suspected": CodeInfo(
        "warning",
        "The body travels implausibly far",
        "Nothing in the data proves the unit, so nothing was changed.",
        "convert to metres if the column is in millimetres",
    ),
    "gap/velocity-frame": CodeInfo(
        "warning",
        "A velocity is in other axes than declared",
        "Angular velocity in body axes taken for world axes is a common false gap of tossed bodies. It was turned, "
        "because only the other frame agrees with the orientation.",
        "declare w_world instead of w_body (or the reverse); v is in world axes",
    ),
    "gap/velocity-inconsistent": CodeInfo(
        "warning",
        "A recorded velocity does not follow from the recorded motion",
        "No unit, frame or order explains the difference: nothing was changed. Roll-outs start from these velocities.",
        "check the column, or leave it out: it can be estimated from positions",
    ),
    "gap/velocity-age": CodeInfo(
        "info",
        "A recorded velocity is older than its stamp",
        "Backward differences lag half a frame, filters more. Nothing was changed: the effect sensor.velocity_age can.",
        "nothing to do; or record centred differences",
    ),
    "gap/gravity-axis": CodeInfo(
        "warning",
        "The body falls along another axis than the declared gravity",
        "A y-up recording taken for z-up makes every comparison meaningless. Nothing was changed.",
        "correct world.gravity_mps2 and the support's normal, or turn the data",
    ),
    # Trials as a set.
    "gap/duplicate-trials": CodeInfo(
        "warning",
        "One recording appears under several ids",
        "Copies, also turned about the vertical, put one motion on both sides of a split. Later copies are left out.",
        "remove the copies",
    ),
    "gap/split-leak": CodeInfo(
        "error",
        "A trial is in train and in test",
        "A gain on data that was fitted proves nothing.",
        "give the trial to one side",
    ),
    "gap/unknown-trial": CodeInfo(
        "error",
        "The split names a trial that does not exist",
        "A misspelt id would silently shrink one side.",
        "use the file's name without extension",
    ),
    "gap/unused-trials": CodeInfo(
        "info",
        "Trials are on neither side of the split",
        "They are read and checked, but neither teach nor judge.",
        "add them to split.train or split.test",
    ),
    "gap/too-few-trials": CodeInfo(
        "warning",
        "There are too few trials for intervals by trial",
        "Rows of one trial are not independent; confidence comes from the number of trials.",
        "record more trials, or cut a long log into segments",
    ),
    "gap/noise-estimated": CodeInfo(
        "info",
        "Sensor noise was estimated from the data",
        "Residuals are counted in units of it. Filtered recordings look quieter than their sensor.",
        "declare sensor_noise if it is known",
    ),
    # Impacts and pushes.
    "gap/kind-unsupported-yet": CodeInfo(
        "error",
        "Measurements of this kind can be read and checked, but not explained yet",
        "A gap between two models can only be found where both can be simulated.",
        "record the joints as `mechanism` or the pose as `free_body` where the set-up allows it",
    ),
    "gap/subject-unsupported-yet": CodeInfo(
        "error",
        "The subject has a form that the simulation cannot build yet",
        "A model that leaves out what it cannot build would show a gap of its own.",
        "give a mechanism as `joints`, a free body as `box` or `mesh`",
    ),
    "gap/unknown-effect": CodeInfo(
        "error",
        "An extension names an effect that the library does not have",
        "Skipping it would simulate a world that nobody measured.",
        "use a name that `mana gap effects` lists, or the version of Mana that wrote the file",
    ),
    "gap/unknown-place": CodeInfo(
        "error",
        "An extension names a joint or body that the model does not have",
        "An effect at the wrong place is worse than none.",
        "correct `where`, or apply the extension to the model that it was found on",
    ),
    "gap/stopped": CodeInfo(
        "error",
        "The search in a folder took too long, too much memory, or crashed",
        "The other folders are not affected.",
        "run `mana gap find` on this folder alone to see what it prints",
    ),
    "gap/missing-report": CodeInfo(
        "error",
        "There is no report of this measurement",
        "A plan starts from what a search left in doubt; the folder holds no report, or that of another recording.",
        "run `mana gap find` on this measurement, and name the folder of its --out",
    ),
    "gap/invalid-extension": CodeInfo(
        "error",
        "A file is no model extension",
        "Effects need their name, their place and a finite value for each of their parameters.",
        "use the `extension.json` that `mana gap find` wrote",
    ),
    "gap/impact-inconsistent": CodeInfo(
        "warning",
        "Events break the mechanics of contact",
        "An approach must close the gap, a departure open it, and no passive contact adds energy; many such rows mean "
        "a wrong sign, unit or Jacobian.",
        "check the signs of the normal Jacobian, and mass and inertia",
    ),
    "gap/push-inconsistent": CodeInfo(
        "warning",
        "A push has no effect or no contact",
        "The body did not move, or the pusher's path stays far from it.",
        "check units and frames of poses and tip; remove failed pushes",
    ),
}

"""Diagnostic codes of recorded episodes and of replay augmentation; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

REPLAY_CODES: dict[str, CodeInfo] = {
    # The recording as files.
    "replay/unknown-format": CodeInfo(
        "error",
        "The path holds no recording in a format that Mana reads",
        "A recording read in the wrong format has another motion than the one that was made.",
        "give a robomimic or robosuite HDF5 file, a ManiSkill .h5 file, a LeRobot data set, or an episode folder "
        "(docs/reference/episode-folder.md)",
    ),
    "replay/missing-file": CodeInfo(
        "error",
        "A file of the recording is absent",
        "Without it the motion or the shape of what moves is not known.",
        "put the file where the message says, or name it with the option given there",
    ),
    "replay/unreadable": CodeInfo(
        "error",
        "A file of the recording cannot be read",
        "A reader that guesses past damage invents motion.",
        "copy or export the file again",
    ),
    "replay/path-escape": CodeInfo(
        "error",
        "A reference leads out of the recording's folder",
        "Following it could read any file on the machine; it is never opened.",
        "copy the file into the folder, or say with --meshes where mesh files are",
    ),
    "replay/missing-mesh": CodeInfo(
        "error",
        "The mesh of something that moves or stands is absent",
        "What has no shape cannot be kept clear of.",
        "put the mesh files into the folder of the recording, or say with --meshes where they are",
    ),
    "replay/uncovered-link": CodeInfo(
        "warning",
        "Something that moves has no shape at hand",
        "It does not collide in its model and the meshes that draw it are absent: nothing keeps clear of it.",
        "say with --meshes where the mesh files are, or give the body a collision geom",
    ),
    "replay/bad-mesh": CodeInfo(
        "error",
        "A mesh cannot be read or spans no volume",
        "What has no shape cannot be kept clear of.",
        "export the mesh again",
    ),
    # The recording as numbers.
    "replay/missing-column": CodeInfo(
        "error",
        "A stream that the model needs was not recorded",
        "A joint or an object without a recorded state could be anywhere.",
        "record the column named, or remove the joint or object from the model",
    ),
    "replay/state-size": CodeInfo(
        "error",
        "The recorded states do not fit the model",
        "States of another model would put every link in a wrong place.",
        "give the model with which the episode was recorded",
    ),
    "replay/not-finite": CodeInfo(
        "error",
        "A recorded value is NaN, infinite or no orientation",
        "One such value leaves the motion around it unknown.",
        "cut the recording at the row named, or repair the value",
    ),
    "replay/time-decreases": CodeInfo(
        "error",
        "A time stamp is smaller than the one before",
        "The order of the samples is not known. Irregular steps and repeats are fine.",
        "sort the rows, or split the recording where the clock was set back",
    ),
    # The recording as a model.
    "replay/invalid-value": CodeInfo(
        "error",
        "A value of the model or the description cannot mean what it says",
        "A model that is guessed at has another motion than the recorded one.",
        "correct the value named",
    ),
    "replay/unsupported-model": CodeInfo(
        "error",
        "The model uses something that Mana does not read",
        "To leave it out would leave something that moves or stands uncovered.",
        "remove the element named, or replace it by joints and geoms that Mana reads (hinge, slide, free)",
    ),
    # Putting objects in.
    "replay/no-support": CodeInfo(
        "error",
        "The episode has no level face to put objects on, or none of the name given",
        "An object without a support would fall, or float.",
        "name one of the supports listed with --support, or add the table to the recording's model",
    ),
    "replay/no-candidates": CodeInfo(
        "error",
        "There is nothing to put in",
        "Objects come from a plan or from released packages.",
        "give --plan, or --assets with a folder of packages (`mana assets ingest`)",
    ),
    "replay/no-room": CodeInfo(
        "warning",
        "A variant has fewer objects than were asked for",
        "No object tried has room outside the swept envelope and clear of what stands; a bad placement is never made.",
        "ask for fewer or smaller objects, name more supports with --support, or lower --clearance",
    ),
    "replay/stopped": CodeInfo(
        "error",
        "Work on a recording took too long, too much memory, or crashed",
        "The other recordings of the batch are not affected.",
        "split the recording, or run it alone to see what it prints",
    ),
    "replay/missing-camera": CodeInfo(
        "error",
        "The recording has no camera to draw",
        "Pictures from a camera that nobody recorded would show what no policy saw.",
        "name cameras that the message lists with --cameras, or describe one in episode.json",
    ),
    "replay/out-taken": CodeInfo(
        "error",
        "The folder for an episode's variants holds something else",
        "To write there would delete a recording, the variants of another one, or files that Mana did not make.",
        "give another --out, or move what is there",
    ),
}

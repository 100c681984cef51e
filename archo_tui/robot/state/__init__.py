"""The state of the robot as it is shown: a snapshot, and the types of what is in it.

They are frozen. `received`, `sent` and the like are seconds on the monotonic clock of this
process, `time` is a Unix time. None means that nothing was received, or that this robot does not
report it. Recordings have the names of the attributes. The `period` of a reading is that of the
robot file or the measured one; without one, `grace` is the silence in seconds that is allowed, None
for any.

Most are NamedTuples, which are made and copied in a fraction of a dataclass's time.
"""

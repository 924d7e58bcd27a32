"""Between mappings with their confidence and mbd_msgs/MappingEstimate."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from mbd_msgs import msg as m
from std_msgs.msg import Header

from mbd_model.estimate import EstimateInputs, Feature, Mapping, MappingEstimate
from mbd_model.ros.conversions.times import stamp_from_msg


def mapping_to_msg(value: Mapping) -> m.Mapping:
    """One mapping."""
    return m.Mapping(
        pairs=[m.Correspondence(source_id=source, target_id=target) for source, target in value.pairs],
        score=value.score,
    )


def mapping_from_msg(msg: m.Mapping) -> Mapping:
    """One mapping."""
    return Mapping(pairs=tuple((p.source_id, p.target_id) for p in msg.pairs), score=float(msg.score))


def estimate_to_msg(
    value: MappingEstimate, *, session: str, threshold: float, stamps: tuple[Time, Time, Time]
) -> m.MappingEstimate:
    """An estimate with the stamps (task, target scene, assists) of the inputs it came from.

    Its own stamp is the latest of those, never the wall clock: the output is a pure function of the inputs.
    """
    return m.MappingEstimate(
        header=Header(stamp=max(stamps, key=lambda t: (t.sec, t.nanosec))),
        session=session,
        strategy=value.strategy,
        mapping=mapping_to_msg(value.mapping),
        confidence=value.confidence,
        threshold=threshold,
        confident=bool(value.mapping.pairs) and value.confidence >= threshold,
        winning=[str(f) for f in value.winning],
        runner_up=[str(f) for f in value.runner_up],
        alternatives=[mapping_to_msg(a) for a in value.alternatives],
        ties=value.ties,
        num_assists=value.num_assists,
        warnings=list(value.warnings),
        next_question=value.next_question,
        information_gain=value.information_gain,
        task_stamp=stamps[0],
        scene_stamp=stamps[1],
        assists_stamp=stamps[2],
    )


def estimate_from_msg(msg: m.MappingEstimate) -> MappingEstimate:
    """An estimate, without its stamps and threshold."""
    return MappingEstimate(
        strategy=msg.strategy,
        mapping=mapping_from_msg(msg.mapping),
        confidence=float(msg.confidence),
        winning=tuple(Feature(f) for f in msg.winning),
        runner_up=tuple(Feature(f) for f in msg.runner_up),
        alternatives=tuple(mapping_from_msg(a) for a in msg.alternatives),
        ties=int(msg.ties),
        num_assists=int(msg.num_assists),
        warnings=tuple(msg.warnings),
        next_question=msg.next_question,
        information_gain=float(msg.information_gain),
    )


def inputs_from_msg(msg: m.MappingEstimate) -> EstimateInputs:
    """Which inputs an estimate came from."""
    return EstimateInputs(
        task_stamp=stamp_from_msg(msg.task_stamp),
        scene_stamp=stamp_from_msg(msg.scene_stamp),
        assists_stamp=stamp_from_msg(msg.assists_stamp),
        threshold=float(msg.threshold),
        confident=bool(msg.confident),
    )

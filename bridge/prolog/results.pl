:- module(bridge_results,
          [ result/3,                   % ?Server, ?Op, ?Type
            message/2                   % ?Name, ?Fields
          ]).

/** <module> The types of the servers' results

Written by `python -m bridge results` from what bridge/image_messages.py and bridge/vision_messages.py state.
What the types mean is said by check_type/3 of bridge/prolog/types.pl.
*/

result(image_server, capture, message('ImageCaptureResult')).
result(image_server, describe, message('Describe')).
result(image_server, health, message('HealthResult')).
result(image_server, hello, message('HelloResult')).
result(image_server, move, message('MoveResult')).
result(image_server, restart, message('RestartResult')).
result(image_server, score, message('ScoreResult')).
result(image_server, shutdown, message('NoArgs')).
result(vision_server, add, message('VisionCaptureResult')).
result(vision_server, appraise, message('AppraiseResult')).
result(vision_server, best, message('EstimateResult')).
result(vision_server, capture, message('VisionCaptureResult')).
result(vision_server, check, message('CheckResult')).
result(vision_server, discard, message('DiscardResult')).
result(vision_server, end, message('NoArgs')).
result(vision_server, estimate, message('EstimateResult')).
result(vision_server, health, message('HealthResult')).
result(vision_server, hello, message('HelloResult')).
result(vision_server, parameters, map(any)).
result(vision_server, predict, message('PredictResult')).
result(vision_server, restore, message('StartResult')).
result(vision_server, shutdown, message('NoArgs')).
result(vision_server, start, message('StartResult')).
result(vision_server, track, message('TrackResult')).

message('AppraiseResult',
        [ gamma-number([])
        ]).
message('CameraDescription',
        [ width-integer([ge(1), le(65536)]),
          height-integer([ge(1), le(65536)]),
          fx-number([gt(0)]),
          fy-number([gt(0)]),
          cx-number([]),
          cy-number([]),
          distortion-optional(list(number([]), 4, 12)),
          lens-optional(one_of(["fisheye", "pinhole"])),
          gain-optional(number([gt(0)])),
          gamma-optional(number([gt(0)])),
          read_noise_e-optional(number([ge(0)])),
          full_well_e-optional(number([gt(0)])),
          bits-optional(integer([ge(8), le(16)])),
          bayer-optional(boolean)
        ]).
message('CauseTold',
        [ cause-one_of(["in_the_way", "light_dead", "lights_swapped", "sun_changed", "target_moved"]),
          lights-optional(list(string, 0, inf)),
          since-optional(nullable(string))
        ]).
message('CheckResult',
        [ probability-number([ge(0), le(1)]),
          state-one_of(["doubtful", "lost", "ok"]),
          better-nullable(message('PoseMessage')),
          better_probability-nullable(number([ge(0), le(1)])),
          covariance-nullable(list(tuple([number([]), number([]), number([]), number([]), number([]), number([])]), 6, 6)),
          difference-nullable(message('PoseErrorMessage')),
          disagreeing_lines-list(integer([ge(0), le(9007199254740992)]), 0, inf),
          disagreeing_images-optional(list(string, 0, inf))
        ]).
message('Describe',
        [ device-string,
          lights-list(message('LightDescription'), 0, inf),
          shutters_s-list(number([ge(1e-09), le(100000.0)]), 1, inf),
          apertures-list(number([ge(0.01), le(10000.0)]), 1, inf),
          focal_lengths_mm-optional(nullable(list(number([gt(0)]), 0, inf))),
          focuses_m-optional(nullable(list(number([gt(0)]), 0, inf))),
          camera-optional(nullable(message('CameraDescription'))),
          reference-optional(message('ReferenceExposure')),
          target-optional(nullable(message('TargetDescription'))),
          movable-optional(boolean),
          nearest_m-optional(nullable(number([gt(0)]))),
          recorded-optional(nullable(integer([ge(1)]))),
          ranges-optional(list(message('SettingRange'), 0, inf)),
          setting_tolerance-optional(number([ge(0)])),
          events-optional(nullable(string))
        ]).
message('DiscardResult',
        [ image-string,
          images-list(string, 0, inf)
        ]).
message('EstimateResult',
        [ pose-nullable(message('PoseMessage')),
          covariance-nullable(list(tuple([number([]), number([]), number([]), number([]), number([]), number([])]), 6, 6)),
          rms_px-nullable(number([ge(0)])),
          uncertainty-nullable(number([ge(0)])),
          supported_fraction-number([ge(0), le(1)]),
          score-number([]),
          ambiguity-number([]),
          lines-list(message('LineTold'), 0, inf),
          rivals-optional(list(message('RivalTold'), 0, inf)),
          poses-optional(list(message('PoseTold'), 0, inf)),
          free-optional(list(tuple([number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)])]), 0, inf)),
          segments-optional(integer([ge(0), le(9007199254740992)])),
          seconds-optional(map(number([ge(0)]))),
          model_wrong-optional(nullable(message('ModelExcess')))
        ]).
message('EventTold',
        [ event-one_of(["camera_fault", "light_fault", "sun_changed", "target_moved"]),
          args-optional(map(any)),
          sequence-optional(integer([ge(0)]))
        ]).
message('FoundSettings',
        [ bits-number([]),
          line-integer([ge(0), le(9007199254740992)]),
          settings-message('Settings')
        ]).
message('FrameStatistics',
        [ mean-number([ge(0), le(1)]),
          p05-number([ge(0), le(1)]),
          p50-number([ge(0), le(1)]),
          p95-number([ge(0), le(1)]),
          dark_fraction-number([ge(0), le(1)]),
          saturated_fraction-number([ge(0), le(1)]),
          sharpness-number([ge(0), le(1)]),
          noise-number([ge(0)]),
          blur_px-nullable(number([ge(0)])),
          frame-message('RegionStatistics')
        ]).
message('Gain',
        [ bits-number([]),
          line-integer([ge(0), le(9007199254740992)])
        ]).
message('HealthResult',
        [ status-string
        ]).
message('HelloResult',
        [ server-string,
          version-string,
          protocol-integer([]),
          operations-list(string, 0, inf),
          pid-integer([])
        ]).
message('ImageCaptureResult',
        [ requested-message('Settings'),
          applied-message('Settings'),
          verified-boolean,
          sequence-integer([ge(0), le(9007199254740992)]),
          timestamp-number([]),
          devices-map(string),
          sha256-string,
          events-optional(list(message('EventTold'), 0, inf))
        ]).
message('LightDescription',
        [ name-string,
          levels-integer([ge(1), le(65536)]),
          position-optional(nullable(tuple([number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)])]))),
          power-optional(number([ge(0)]))
        ]).
message('LineTold',
        [ line-integer([ge(0), le(9007199254740992)]),
          visible_px-number([ge(0)]),
          support-nullable(number([])),
          rms_px-nullable(number([ge(0)])),
          image-optional(nullable(string))
        ]).
message('ModelExcess',
        [ axis-one_of(["x", "y", "z"]),
          share-number([])
        ]).
message('ModelTold',
        [ name-string,
          lines-integer([ge(0), le(9007199254740992)]),
          faces-integer([ge(0), le(9007199254740992)]),
          diameter_m-optional(nullable(number([ge(0)]))),
          picture_px-optional(nullable(number([ge(0)]))),
          doubt-optional(nullable(string))
        ]).
message('MoveResult',
        [ range_m-number([gt(0), le(1000000.0)]),
          events-list(message('EventTold'), 0, inf)
        ]).
message('MovedTold',
        [ shift_px-tuple([number([]), number([])]),
          box_px-tuple([integer([]), integer([]), integer([]), integer([])])
        ]).
message('NoArgs',
        [ 
        ]).
message('PoseErrorMessage',
        [ rotation_deg-number([ge(0)]),
          translation_m-number([ge(0)]),
          translation_fraction_of_range-number([ge(0)])
        ]).
message('PoseMessage',
        [ rotation_vector-tuple([number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)])]),
          translation-tuple([number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)])])
        ]).
message('PoseTold',
        [ pose-message('PoseMessage'),
          probability-number([ge(0), le(1)])
        ]).
message('PredictResult',
        [ gains-nullable(list(message('Gain'), 0, inf)),
          found-optional(list(message('FoundSettings'), 0, inf))
        ]).
message('ReferenceExposure',
        [ shutter_s-optional(number([ge(1e-09), le(100000.0)])),
          aperture-optional(number([ge(0.01), le(10000.0)]))
        ]).
message('RegionStatistics',
        [ mean-number([ge(0), le(1)]),
          p05-number([ge(0), le(1)]),
          p50-number([ge(0), le(1)]),
          p95-number([ge(0), le(1)]),
          dark_fraction-number([ge(0), le(1)]),
          saturated_fraction-number([ge(0), le(1)]),
          sharpness-number([ge(0), le(1)]),
          noise-number([ge(0)])
        ]).
message('RestartResult',
        [ events-list(message('EventTold'), 0, inf)
        ]).
message('RivalTold',
        [ pose-message('PoseMessage'),
          share-number([ge(0)])
        ]).
message('ScoreResult',
        [ error-nullable(message('PoseErrorMessage'))
        ]).
message('SettingRange',
        [ name-string,
          unit-string,
          minimum-number([]),
          maximum-number([]),
          step-optional(nullable(number([])))
        ]).
message('Settings',
        [ lights-list(integer([ge(0), le(65535)]), 0, inf),
          shutter_s-number([ge(1e-09), le(100000.0)]),
          aperture-number([ge(0.01), le(10000.0)]),
          focal_length_mm-optional(nullable(number([gt(0), le(1000000.0)]))),
          focus_m-optional(nullable(number([gt(0), le(1000000.0)])))
        ]).
message('StartResult',
        [ model-message('ModelTold'),
          describe-message('Describe')
        ]).
message('TargetDescription',
        [ model-string,
          unit-optional(one_of(["cm", "in", "m", "mm"])),
          seed_pose-optional(nullable(message('PoseMessage'))),
          range_m-optional(nullable(tuple([number([gt(0), le(1000000.0)]), number([gt(0), le(1000000.0)])]))),
          view-optional(nullable(tuple([number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)]), number([ge(-1000000.0), le(1000000.0)])]))),
          tolerance_m-optional(nullable(number([ge(0), le(1000000.0)])))
        ]).
message('TrackResult',
        [ frame-integer([ge(0), le(9007199254740992)]),
          state-one_of(["lost", "sure", "unsure"]),
          pose-nullable(message('PoseMessage')),
          covariance-nullable(list(tuple([number([]), number([]), number([]), number([]), number([]), number([])]), 6, 6)),
          seconds-number([ge(0)]),
          note-optional(string)
        ]).
message('VisionCaptureResult',
        [ image-string,
          applied-message('Settings'),
          verified-boolean,
          statistics-message('FrameStatistics'),
          seconds-map(number([ge(0)])),
          surprise-optional(nullable(message('CauseTold'))),
          doubt-optional(nullable(message('CauseTold'))),
          events-optional(list(message('EventTold'), 0, inf)),
          moved-optional(nullable(message('MovedTold'))),
          repeats-optional(nullable(string))
        ]).
